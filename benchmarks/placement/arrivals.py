"""Arrivals and departures of robots that need containers, generated or recorded."""

from collections.abc import Iterator
from heapq import heappop, heappush
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from engine.specs.containers import ContainerSpec, MapVersion, RobotConfig
from ppaas.errors import InvalidInput

SIZES, SHARES = (0.25, 0.5, 1.0, 2.0), (0.5, 0.3, 0.15, 0.05)
"""Sizes of containers [cores], and their shares."""

ZIPF = 0.8
"""Zipf exponent of the robots of a map: a few warehouses have many robots, most homes have one."""


class RobotArrival(msgspec.Struct, frozen=True):
    """A robot that needs a container.

    Parameters
    ----------
    at : float
        Arrival time [s].
    robot, map : str
        Name of the robot, and id of its map.
    cores : float
        Size of the container [cores].
    stays : float
        Time until the robot leaves [s].
    """

    at: float
    robot: str
    map: str
    cores: float = 1.0
    stays: float = float("inf")

    def spec(self, number: int) -> ContainerSpec:
        """Return the specification of its container."""
        config = RobotConfig(self.robot, "turtlebot2", (0.0, 0.0, 0.0), "dijkstra", "dwa")
        return ContainerSpec(f"c{number}", "fleet", MapVersion(self.map, "v1"), self.cores, config)


class Event(NamedTuple):
    """A robot that arrives (``comes``), numbered in the order of arrivals, or leaves."""

    at: float
    comes: bool
    number: int
    robot: RobotArrival


def generated(robots: int, maps: int, seed: int, changes: float = 0.5) -> Iterator[RobotArrival]:
    """Yield random robots in the order of their arrivals.

    Parameters
    ----------
    robots, maps : int
        Numbers of robots and maps.
    seed : int
        Random seed.
    changes : float
        Share of the robots that leave before the last one arrives.
    """
    random = np.random.default_rng(seed)
    weights = np.arange(1, maps + 1, dtype=np.float64) ** -ZIPF
    places = random.choice(maps, robots, p=weights / weights.sum())
    sizes = random.choice(SIZES, robots, p=SHARES)
    at = np.sort(random.random(robots))
    stays = np.where(random.random(robots) < changes, random.random(robots), np.inf)
    rows = zip(at.tolist(), places.tolist(), sizes.tolist(), stays.tolist(), strict=True)
    for number, (when, place, size, stay) in enumerate(rows):
        yield RobotArrival(when, f"r{number}", f"map{place}", size, stay)


def recorded(file: Path) -> Iterator[RobotArrival]:
    """Yield the robots of a file: one JSON object a line with the fields of `RobotArrival`, in order of ``at``.

    Raises
    ------
    InvalidInput
        A line is not a valid arrival, or is earlier than the one before.
    """
    decoder, before = msgspec.json.Decoder(RobotArrival), float("-inf")
    with file.open("rb") as lines:
        for number, line in enumerate(lines, 1):
            try:
                arrival = decoder.decode(line)
            except msgspec.DecodeError as error:
                raise InvalidInput(f"{file}, line {number}: {error}") from error
            if not (before <= arrival.at < float("inf") and arrival.cores > 0.0):
                raise InvalidInput(f"{file}, line {number}: times must not decrease, and cores must be above 0")
            before = arrival.at
            yield arrival


def events(arrivals: Iterator[RobotArrival]) -> Iterator[Event]:
    """Yield arrivals and departures in order, without the departures after the last arrival."""
    leaving: list[tuple[float, int, RobotArrival]] = []
    for number, arrival in enumerate(arrivals):
        while leaving and leaving[0][0] <= arrival.at:
            yield Event(leaving[0][0], False, *heappop(leaving)[1:])
        if arrival.stays < float("inf"):
            heappush(leaving, (arrival.at + arrival.stays, number, arrival))
        yield Event(arrival.at, True, number, arrival)
