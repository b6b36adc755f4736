"""Robots of the cloud as AGVs: master controls over mosquitto drive simulated robots by orders of VDA 5050."""

import asyncio
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from ppaas.clock import epoch
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.base.message import Empty
from ppaas.messages.std_srvs import Trigger, TriggerResponse
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.fields import Point
from ppaas.wire.vda5050.topics import Version
from ppaas.wire.vda5050.zones import Zone, Zones, ZoneSet
from robots import cli
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.network.certificates import TestAuthority
from tests.support.vda5050.master import commanding, route
from tests.support.vda5050.mosquitto import Mosquitto
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

FOLDER = Path(__file__).parent / "vda5050"
LOGIN = "fleet", "a secret of the hall"


@contextmanager
def bridging(*arguments: str, broker: Mosquitto, cloud: RunningCloud, log: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Run ``ppaas bridge vda5050``; print its log at the end, which pytest shows of a failed test."""
    command = [sys.executable, "-m", cli.__name__, "bridge", "vda5050", *arguments]
    options = ["--broker", broker.url, "--url", cloud.url, "--token", str(cloud.token)]
    password = {"PPAAS_MQTT_PASSWORD": broker.login[1]} if broker.login is not None else {}
    with log.open("ab") as output:
        process = subprocess.Popen([*command, *options], stdout=output, stderr=output, env=os.environ | password)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(20)
        sys.stdout.write(log.read_text())


async def places(cloud: RunningCloud, grid: GridMap, robot: str) -> tuple[str, list[Pose2D]]:
    """Register a robot; return its token, its place, and two others."""
    rest = await cloud.admin()
    await publish_map(rest, "office", grid)
    start = free_pose(grid, seed=61)
    near = reachable_pose(grid, start, seed=62, at_least=0.8, at_most=1.6)
    next_to = reachable_pose(grid, near, seed=63, at_least=0.8, at_most=1.6)
    return await register_robot(rest, robot, "office", start), [start, near, next_to]


async def test_the_master_of_vda_5050_lib_drives_a_robot_over_tls(
    node: str, cloud: RunningCloud, office_map: GridMap, tmp_path: Path
) -> None:
    if not (FOLDER / "node_modules" / "vda-5050-lib").is_dir():
        pytest.skip("vda-5050-lib is not installed: install Node 20 or newer and run make test")
    authority = TestAuthority(tmp_path)
    broker = Mosquitto(tmp_path, LOGIN, authority.issue("broker"))
    broker.start()
    token, (start, near, next_to) = await places(cloud, office_map, "vda")
    beeps = []

    async def beep(_: Empty) -> TriggerResponse:
        beeps.append(epoch())
        return TriggerResponse(success=True, message="beeped")

    told: dict[str, Any] = {
        "transport": {
            "brokerUrl": f"mqtts://localhost:{broker.port}",
            "username": LOGIN[0],
            "password": LOGIN[1],
            "tlsOptions": {"ca": authority.file.read_text()},
        },
        "agv": {"manufacturer": "ppaas", "serialNumber": "vda"},
        "mapId": "office",
        "nodes": [{"x": place.x, "y": place.y} for place in (start, near, next_to)],
        "away": {"x": start.x + 3.0, "y": start.y},
    }
    options = ["vda", "--vda", "2.0", "--action", "beep=beep", "--state-interval", "1"]
    try:
        async with driving(cloud.url, token, "vda", office_map, start) as drive:
            await drive.robot.advertise_service("beep", Trigger, beep)
            ca = ["--broker-ca-file", str(authority.file)]
            with bridging(*options, *ca, broker=broker, cloud=cloud, log=tmp_path / "log"):
                script = await asyncio.create_subprocess_exec(
                    node, "master.mjs", json.dumps(told), cwd=FOLDER,
                    stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE,
                )  # fmt: skip
                try:
                    output, errors = await asyncio.wait_for(script.communicate(), 150.0)
                except TimeoutError:
                    script.kill()
                    output, errors = await script.communicate()
    finally:
        broker.kill()
    assert output, errors.decode()
    found = json.loads(output)
    assert found["connection"][-1] == "ONLINE"
    assert found["position"]["mapId"] == "office" and found["position"]["x"] == pytest.approx(start.x, abs=0.3)
    assert found["base"] == "traversed"
    assert found["order"] == {"error": None, "cancelled": False, "active": False}
    assert list(dict.fromkeys(found["traversed"])) == ["n0", "n1", "n2"]
    assert ["a1", "FINISHED", "beeped"] in found["actions"] and len(beeps) == 1
    assert found["refused"]["error"] == "noRouteError"
    assert found["instant"][0] == ["stateRequest", "FINISHED", None]
    assert found["instant"][1][:2] in (["explode", "FAILED"], ["explode", "ERROR"])
    assert found["instant"][2] == ["cancelOrder", "FINISHED", None]
    assert found["cancelled"]["cancelled"] is True
    assert "INFO connected to the broker" in (tmp_path / "log").read_text()


def localized(state: Any) -> bool:
    return bool(state.mobile_robot_position.localized)


async def test_an_agv_survives_its_broker_and_its_bridge(
    cloud: RunningCloud, office_map: GridMap, tmp_path: Path
) -> None:
    broker = Mosquitto(tmp_path)
    broker.start()
    token, (start, near, next_to) = await places(cloud, office_map, "tough")
    options = ["tough", "--vda", "2.1", "--state-interval", "1"]
    running = {"broker": broker, "cloud": cloud, "log": tmp_path / "log"}
    version = Version.V2_1
    try:
        async with driving(cloud.url, token, "tough", office_map, start) as drive:
            with bridging(*options, **running) as bridge:  # type: ignore[arg-type]
                async with commanding(broker, version, "tough") as master:
                    await master.until(topics.STATE, localized)
                    await master.send_raw(topics.ORDER, b"\xff{]")
                    await master.until(topics.STATE, lambda state: errors(state) == {"validationError"})
                    await master.send(topics.ORDER, route([start, near, next_to], 1), times=3)
                    await master.until(topics.STATE, lambda state: state.driving)
                    await master.send(topics.ORDER, route([near, next_to], 2, first=1, update=2))
                    await master.send(topics.ORDER, route([near, next_to], 2, first=1, update=1))
                    await master.until(topics.STATE, lambda state: "orderUpdateError" in errors(state))
                broker.kill()
                await asyncio.sleep(2.0)
                broker.start()
                async with commanding(broker, version, "tough") as master:
                    await master.until(topics.CONNECTION, lambda one: one.connection_state == "ONLINE")
                    end = await master.until(topics.STATE, lambda state: state.last_node_id == "n2", 90.0)
                    assert end.node_states == [] and not end.driving and end.order_update_id == 2
                    assert drive.scorer.error(0, next_to) < 0.3
                    bridge.kill()
                    await master.until(topics.CONNECTION, lambda one: one.connection_state == "CONNECTION_BROKEN", 60.0)
                    await master.send(topics.ORDER, route([next_to, near], 1, order_id="old"), retain=True)
                    master.heard[topics.STATE].clear()
                    with bridging(*options, **running):  # type: ignore[arg-type]
                        await master.until(topics.CONNECTION, lambda one: one.connection_state == "ONLINE")
                        state = await master.until(topics.STATE, localized)
                        assert (state.order_id, state.driving) == ("", False)
                    await master.until(topics.CONNECTION, lambda one: one.connection_state == "OFFLINE")
                    assert master.problems == []
    finally:
        broker.kill()


def errors(state: Any) -> set[str]:
    return {one.error_type for one in state.errors}


async def test_zones_of_version_3_turn_the_robot_away(cloud: RunningCloud, office_map: GridMap, tmp_path: Path) -> None:
    broker = Mosquitto(tmp_path)
    broker.start()
    token, (start, near, _) = await places(cloud, office_map, "zoned")
    options = ["zoned", "--vda", "3.0", "--zones", "--visualization", "0.5"]
    around = [(near.x + dx, near.y + dy) for dx, dy in ((-0.4, -0.4), (0.4, -0.4), (0.4, 0.4), (-0.4, 0.4))]
    vertices = [Point(x=x, y=y) for x, y in around]
    blocked = Zone(zone_id="a", zone_type="BLOCKED", vertices=vertices)
    slow = Zone(zone_id="b", zone_type="SPEED_LIMIT", vertices=vertices, maximum_speed=0.2)
    release = Zone(zone_id="c", zone_type="RELEASE", vertices=vertices, release_loss_behavior="STOP")

    def a_set(name: str, *zones: Zone) -> ZoneSet:
        return ZoneSet(zone_set=Zones(map_id="office", zone_set_id=name, zones=list(zones)))

    try:
        with bridging(*options, broker=broker, cloud=cloud, log=tmp_path / "log"):
            async with commanding(broker, Version.V3_0, "zoned") as master:
                sheet = await master.until(topics.FACTSHEET, lambda _: True)
                assert sheet.type_specification.supported_zones == ["BLOCKED", "SPEED_LIMIT"]
                async with driving(cloud.url, token, "zoned", office_map, start):
                    await master.until(topics.STATE, localized)
                    await master.send(topics.ZONE_SET, a_set("refused", release))
                    await master.until(topics.STATE, lambda state: errors(state) == {"INVALID_ZONE_SET"})
                    await master.send(topics.ZONE_SET, a_set("closed", blocked, slow))
                    await master.act("enableZoneSet", "i1", zoneSetId="closed")
                    state = await master.until(topics.STATE, ended_of("i1"))
                    assert [(one.zone_set_id, one.zone_set_status) for one in state.zone_sets] == [
                        ("closed", "ENABLED")
                    ]
                    assert [one.action_status for one in state.instant_action_states] == ["FINISHED"]
                    await master.send(topics.ORDER, route([start, near], 1, order_id="o1"))
                    await master.until(topics.STATE, lambda state: errors(state) == {"NODE_UNREACHABLE"}, 60.0)
                    await master.act("cancelOrder", "i2", orderId="o1")
                    await master.until(topics.STATE, ended_of("i2"))
                    await master.send(topics.ZONE_SET, a_set("open"))
                    await master.act("enableZoneSet", "i3", zoneSetId="open")
                    await master.until(topics.STATE, ended_of("i3"))
                    await master.send(topics.ORDER, route([start, near], 1, order_id="o2"))
                    shown = await master.until(topics.VISUALIZATION, lambda one: one.planned_path is not None)
                    assert len(shown.planned_path.trajectory.control_points) > 1
                assert master.problems == []
    finally:
        broker.kill()


def ended_of(action_id: str) -> Callable[[Any], bool]:
    def check(state: Any) -> bool:
        return any(
            one.action_id == action_id and one.action_status in ("FINISHED", "FAILED")
            for one in state.instant_action_states
        )

    return check
