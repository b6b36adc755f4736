"""Open-RMF as a fleet driver sees it, over DDS with types that Cyclone DDS codes itself.

It does what the adapter ``full_control`` does: it repeats a request until a state has its task, and counts the
waypoints that a state lists.
"""

import asyncio
import itertools
import os
from dataclasses import dataclass, field

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float32, int32, sequence, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from robots.bridges.dds.cyclone import cyclone_configuration

PACKAGE = "rmf_fleet_msgs.msg.dds_"
RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))
REPEAT = 0.2
"""Time after which a request that is not confirmed is repeated [s]."""


@dataclass
class Time(IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
class Location(IdlStruct, typename=f"{PACKAGE}.Location_"):
    t: Time = field(default_factory=Time)
    x: float32 = 0.0
    y: float32 = 0.0
    yaw: float32 = 0.0
    obey_approach_speed_limit: bool = False
    approach_speed_limit: float32 = 0.0
    level_name: str = ""
    index: uint64 = 0


@dataclass
class RobotMode(IdlStruct, typename=f"{PACKAGE}.RobotMode_"):
    mode: uint32 = 0
    mode_request_id: uint64 = 0
    performing_action: str = ""


@dataclass
class RobotState(IdlStruct, typename=f"{PACKAGE}.RobotState_"):
    name: str
    model: str
    task_id: str
    seq: uint64
    mode: RobotMode
    battery_percent: float32
    location: Location
    path: sequence[Location]


@dataclass
class FleetState(IdlStruct, typename=f"{PACKAGE}.FleetState_"):
    name: str
    robots: sequence[RobotState]


@dataclass
class PathRequest(IdlStruct, typename=f"{PACKAGE}.PathRequest_"):
    fleet_name: str
    robot_name: str
    path: sequence[Location]
    task_id: str


@dataclass
class ModeParameter(IdlStruct, typename=f"{PACKAGE}.ModeParameter_"):
    name: str
    value: str


@dataclass
class ModeRequest(IdlStruct, typename=f"{PACKAGE}.ModeRequest_"):
    fleet_name: str
    robot_name: str
    mode: RobotMode
    task_id: str
    parameters: sequence[ModeParameter]


class RmfPeer:
    """Adapter of one fleet.

    Parameters
    ----------
    domain : int
        Domain of ROS 2.
    fleet : str
        Name of the fleet.
    """

    def __init__(self, domain: int, fleet: str) -> None:
        self._fleet, self._tasks = fleet, itertools.count(1)
        self._domain = Domain(domain, cyclone_configuration(os.environ))
        self._participant = DomainParticipant(domain)
        self._states = DataReader(self._participant, self._topic("fleet_states", FleetState), qos=RELIABLE)
        self._paths = DataWriter(self._participant, self._topic("robot_path_requests", PathRequest), qos=RELIABLE)
        self._modes = DataWriter(self._participant, self._topic("robot_mode_requests", ModeRequest), qos=RELIABLE)
        self.robots: dict[str, RobotState] = {}

    def _topic(self, name: str, kind: type[IdlStruct]) -> Topic:
        return Topic(self._participant, f"rt/{name}", kind)

    def look(self) -> dict[str, RobotState]:
        """Return the newest states of the robots, by name."""
        for state in self._states.take(N=100):
            if isinstance(state, FleetState) and state.name == self._fleet:
                self.robots = {robot.name: robot for robot in state.robots}
        return self.robots

    async def follow(self, robot: str, path: list[Location]) -> str:
        """Request a path until it is confirmed; return its task."""
        task = str(next(self._tasks))
        return await self._confirmed(robot, task, self._paths, PathRequest(self._fleet, robot, path, task))

    async def set_mode(self, robot: str, mode: int) -> str:
        """Request a mode until it is confirmed; return its task."""
        task = str(next(self._tasks))
        request = ModeRequest(self._fleet, robot, RobotMode(mode), task, [])
        return await self._confirmed(robot, task, self._modes, request)

    async def _confirmed(self, robot: str, task: str, writer: DataWriter[IdlStruct], request: IdlStruct) -> str:
        while self.look().get(robot) is None or self.robots[robot].task_id != task:
            writer.write(request)
            await asyncio.sleep(REPEAT)
        return task

    async def finished(self, robot: str) -> list[int]:
        """Wait until a robot has no path; return how many waypoints remained meanwhile, each number once."""
        seen: list[int] = []
        while True:
            state = self.look().get(robot)
            if state is not None and [len(state.path)] != seen[-1:]:
                seen.append(len(state.path))
            if state is not None and not state.path:
                return seen
            await asyncio.sleep(0.02)
