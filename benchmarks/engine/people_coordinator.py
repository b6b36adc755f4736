"""Coordinator of people: time until it is up, until a report is in its state, and until it is replaced after a crash.

A robot sends reports that differ in its position, and receives the states of its group's coordinator. A state follows
each cycle of the coordinator, so half a cycle of waiting is part of the median.
"""

import asyncio
import contextlib
import os
import signal
from collections.abc import AsyncIterator

from rich.progress import Progress

from benchmarks.engine import baselines
from benchmarks.engine.driving_robot import PATIENCE, grid_to_drive_on
from benchmarks.engine.options import PAUSES, EngineOptions
from benchmarks.engine.recovery import CRASH_LIMITS_MS
from benchmarks.engine.site import EngineSite
from benchmarks.harness.cloud_under_test import CORES
from benchmarks.harness.figures import Figure, median_and_p99, median_and_worst, median_of, served_after
from engine.container.group_bridges import PEOPLE_PERIOD
from ppaas.clock import epoch, monotonic
from ppaas.errors import NotFound, Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance
from ppaas.messages.people_coordination import PeopleReport, PeopleState
from ppaas.nodes.people_coordinator.node import PERIOD
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile

PART = "people"
ROUNDS, QUICK_ROUNDS = 100, 3
CRASHES, QUICK = 5, 1

LIMIT_MS = 250.0
"""Limit of the time from a report to a state with it [ms]: a cycle, and 50 ms for the links."""

STEP = 0.001
"""Distance between the positions of consecutive reports [m]: they identify the report in a state."""

START = 3.0
"""First position in x and y [m]."""


class CoordinatedRobot:
    """A robot that reports where it is, and receives the states of its coordinator.

    Parameters
    ----------
    client : RobotClient
        Its open connection.
    robot : str
        Robot ID.

    Attributes
    ----------
    states : list of float
        Arrival times of the states [monotonic s].
    """

    def __init__(self, client: RobotClient, robot: str) -> None:
        self._client, self._robot = client, robot
        self._reports, self._shown = 0, float("nan")
        self._news = asyncio.Event()
        self.states: list[float] = []

    def heard(self, state: PeopleState) -> None:
        """Record a state."""
        self.states.append(monotonic())
        self._shown = next((one.position.x for one in state.robots if one.robot == self._robot), self._shown)
        self._news.set()

    async def report(self) -> float:
        """Send the next report; return its position in x [m]."""
        self._reports += 1
        x = START + self._reports * STEP
        header = Header(stamp=Time.of(epoch()), frame_id="map")
        pose = PoseWithCovariance(Pose.of(Pose2D(x, START)))
        await self._client.publish("people_tracker/report", PeopleReport(header, self._robot, pose))
        return x

    async def answered(self) -> float:
        """Send a report; return the time until a state has it [s].

        Raises
        ------
        Unavailable
            No such state arrives within the time limit.
        """
        sent = monotonic()
        x = await self.report()
        while not abs(self._shown - x) < STEP / 10.0:
            await self.next_state()
            if self.states[-1] - sent > PATIENCE:
                raise Unavailable(f"no state had the report of robot {self._robot!r} within {PATIENCE:g} s")
        return self.states[-1] - sent

    async def next_state(self) -> None:
        """Wait for a state.

        Raises
        ------
        Unavailable
            None arrives within the time limit.
        """
        self._news.clear()
        try:
            async with asyncio.timeout(PATIENCE):
                await self._news.wait()
        except TimeoutError as error:
            raise Unavailable(f"no state of the people coordinator arrived within {PATIENCE:g} s") from error


async def measure(site: EngineSite, options: EngineOptions, progress: Progress) -> list[Figure]:
    """Measure reports of one group, and kill the coordinators of several, each of them once."""
    first, delays, silences, started = [], list[float](), [], []
    for number in progress.track(range(options.of(CRASHES, QUICK)), description="coordinators of people"):
        map_id = f"bench-people-{number}"
        async with reporting(site, map_id) as (robot, took):
            first.append(took)
            if not number:
                delays = await _delays(robot, options.of(ROUNDS, QUICK_ROUNDS))
            await asyncio.sleep(PAUSES.get(options.runtime, 0.0))
            silences.append(await _crash(site, map_id, robot))
        started.append(await baselines.python())
    note = f"{options.runtime}; from kill -9 of its container until its next state arrives"
    return [
        median_of(PART, "first state", first, note=f"{options.runtime}; from the connection of the first robot"),
        *median_and_p99(PART, "report in a state", delays, limit=LIMIT_MS, note=f"a cycle each {1e3 * PERIOD:.0f} ms"),
        *median_and_worst(PART, "states again", silences, limit=CRASH_LIMITS_MS.get(options.runtime), note=note),
        baselines.python_figure(PART, started),
    ]


@contextlib.asynccontextmanager
async def reporting(site: EngineSite, map_id: str) -> AsyncIterator[tuple[CoordinatedRobot, float]]:
    """Open a robot on a map of its own; yield it with the time until the first state of its coordinator [s]."""
    name = f"{map_id}-robot"
    await site.target.publish(map_id, grid_to_drive_on())
    file = RobotFile(map=map_id, initial_pose=(START, START, 0.0), cores=CORES, parameters={"people_tracker": {}})
    await site.target.rest.put_robot(name, file)
    began = monotonic()
    async with RobotClient(site.target.url, robot=name, token=site.target.token) as client:
        robot = CoordinatedRobot(client, name)
        await client.subscribe("people_coordinator/state", PeopleState, robot.heard)
        await robot.next_state()
        yield robot, robot.states[0] - began


async def _delays(robot: CoordinatedRobot, rounds: int) -> list[float]:
    """Return the times from reports to states that have them [s]; reports are sent at all times of a cycle."""
    delays = []
    for number in range(rounds):
        await asyncio.sleep(PEOPLE_PERIOD + PERIOD * (number % 10) / 10.0)
        delays.append(await robot.answered())
    return delays


async def _crash(site: EngineSite, map_id: str, robot: CoordinatedRobot) -> float:
    pid = await _pid(site, map_id)
    await robot.next_state()
    killed = monotonic()
    os.kill(pid, signal.SIGKILL)
    while robot.states[-1] < killed or served_after(robot.states, killed) < PERIOD:
        await robot.next_state()
    await robot.answered()
    return served_after(robot.states, killed)


async def _pid(site: EngineSite, map_id: str) -> int:
    """Return the process id of the coordinator on a map.

    Raises
    ------
    NotFound
        There is none.
    """
    for view in await site.target.rest.items("/v1/containers"):
        if (view["kind"], view["map"]["id"]) == ("coordinator", map_id):
            return int(view["pid"])
    raise NotFound("people coordinator on map", map_id)
