"""Any message of MAVLink with any values is taken without an exception, and what is published stays JSON."""

import json
import math
import random
from typing import Any

import pytest

from ppaas.messages import encode
from robots.bridges.mavlink.dialect import Parser, mavlink
from tests.support.mavlink.closed_loop import ClosedLoop

SPECIAL = [math.nan, math.inf, -math.inf, 1e38, -1e38, 0.0, 1.0]
WANTED = (
    "HEARTBEAT", "GLOBAL_POSITION_INT", "LOCAL_POSITION_NED", "ATTITUDE", "ODOMETRY", "GPS_RAW_INT", "BATTERY_STATUS",
    "SYS_STATUS", "STATUSTEXT", "COMMAND_ACK", "MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK",
    "MISSION_CURRENT", "MISSION_ITEM_REACHED", "OBSTACLE_DISTANCE", "DISTANCE_SENSOR", "SYSTEM_TIME",
)  # fmt: skip


def anything(kind: Any, rng: random.Random) -> bytes:
    """Return the bytes of a message of a kind with random values."""
    values: list[Any] = []
    for name, type_name in zip(kind.fieldnames, kind.fieldtypes, strict=True):
        count = kind.array_lengths[kind.ordered_fieldnames.index(name)]
        if type_name == "char":
            values.append(rng.randbytes(max(count, 1)))
        elif type_name in ("float", "double"):
            values.append([rng.choice(SPECIAL) for _ in range(count)] if count else rng.choice(SPECIAL))
        else:
            bits, signed = int("".join(filter(str.isdigit, type_name))), not type_name.startswith("u")
            low, high = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if signed else (0, 2**bits - 1)
            values.append([rng.randint(low, high) for _ in range(count)] if count else rng.randint(low, high))
    writer = Parser(1)
    writer.srcComponent = 1
    return writer.write(kind(*values))


@pytest.mark.parametrize("waypoints", [False, True])
def test_no_message_ends_the_bridge(waypoints: bool) -> None:
    loop, rng, reader = ClosedLoop("ardupilot", waypoints=waypoints), random.Random(7), Parser(255)
    kinds = [kind for kind in mavlink.mavlink_map.values() if kind.msgname in WANTED]
    assert len(kinds) == len(WANTED)
    loop.run(2.0)
    for turn in range(40):
        if waypoints:
            loop.follow(f"p{turn}", (5.0, float(turn)))
        loop.speed = 0.3
        for kind in rng.sample(kinds, len(kinds)):
            for message in reader.read(anything(kind, rng)):
                loop.rover.take(message, loop.now)
        loop.run(0.1)
    for scan in loop.cloud.scans:
        json.loads(encode(scan))
    assert all(motion.pose.is_finite() and math.isfinite(motion.forward) for motion in loop.cloud.motions)
    assert all(text.isprintable() for text in loop.cloud.words)
    assert reader.read(rng.randbytes(5000)) is not None
