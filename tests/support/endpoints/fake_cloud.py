"""Fake control plane without machines, with responses set by the test."""

import base64
import hashlib
import json
import math
from collections.abc import Callable
from functools import partial

import msgspec
import numpy as np
from msgspec import Raw

from engine.control.administration import machine_view
from engine.control.counts import ControlCounts
from engine.control.master_calls.cloud import UserQuotas
from engine.control.master_calls.control_plane import (
    ContainerCalls,
    CountPaths,
    MachineCalls,
    MapCalls,
    MoveCalls,
    NeighbourCalls,
    PeopleCalls,
    RobotCalls,
    TaskCalls,
    TrafficCalls,
    UserCalls,
)
from engine.control.planning.planning import Planning
from engine.control.planning.requests import CostAnswer, CostRequest, FleetAnswer, FleetRequest
from engine.control.robot_navigation import RobotNavigation
from engine.control.robot_nodes import RobotNodes
from engine.control.robot_stops import RobotStops, StopCalls
from engine.control.views import (
    ContainerView,
    EndpointView,
    LifelongRobot,
    MachineView,
    MappingRobot,
    PeopleGroupView,
)
from engine.links.place_link import PlaceLink
from engine.links.presence import RobotPresence
from engine.master.machine import Machine, Software
from engine.master.places import PlaceRequest, robot_key
from engine.master.quotas import Quotas
from engine.specs.containers import ContainerSpec, MapVersion
from engine.specs.machine_settings import MachineSettings
from engine.specs.start_state import READY
from ppaas.diagnosis.observations.facts import Observations
from ppaas.errors import Conflict, NotFound, PPaaSError, Unavailable
from ppaas.geometry import Pose2D, Poses, poses_along
from ppaas.messages.base.message import Message
from ppaas.messages.fleet.traffic import TrafficState
from ppaas.messages.health.watching import RecorderState
from ppaas.messages.octomap_msgs import GetOctomapFileRequest, GetOctomapFileResponse
from ppaas.messages.people_coordination import PeopleState, ZoneCount
from ppaas.messages.ppaas_msgs import NodeHome
from ppaas.messages.slam_toolbox import GetPoseGraphResponse, UseJointMapRequest, UseJointMapResponse
from ppaas.people.settings import PeopleSettings
from ppaas.plans.encoding.codes import pack_poses
from ppaas.plans.path_service import PathAnswer, PathRequest
from storage.memory.store import MemoryStore
from storage.records import Limits, MapRecord

MAP_PAGE = 1000
"""Size of a page of the map that a robot makes [bytes]."""


def machine() -> Machine:
    """Return a machine that runs a container."""
    carries = {"c1": ContainerSpec("c1", "ann", MapVersion("house", "v"), 1.0)}
    return Machine(
        "m1",
        4,
        8 << 30,
        1000,
        containers=carries,
        given=1.0,
        cpu=0.5,
        memory_used=1 << 30,
        network_used=2.0 * (1 << 20),
        round_trip=0.0015,
        software=Software("0.2.0", 2),
    )


def endpoint(name: str, **fields: object) -> EndpointView:
    """Return an endpoint of machine m1 with three sockets."""
    given = {"machine": "m1", "pid": 4711, "url": "http://127.0.0.1:8500", "release": "0.2.0", "sockets": 3}
    given |= {"frames": 60.0, "cpu": 0.25, "memory": 90 << 20, "state": "ready"}
    return EndpointView(name, **(given | fields))  # type: ignore[arg-type]


def container(container_id: str = "c1", **fields: object) -> ContainerView:
    """Return a container of ann's robot tb1 in the map house."""
    given = {"kind": "robot", "user": "ann", "robot": "tb1", "map": MapVersion("house", "v"), "machine": "m1"}
    return ContainerView(container_id, **(given | {"cores": 1.0, "state": "ready", "pid": 42} | fields))  # type: ignore[arg-type]


class FakePart:
    """Part of a master, as the test sets it in the cloud."""

    def __init__(self, cloud: "FakeCloud") -> None:
        self._cloud = cloud


class FakeMachines(FakePart):
    """Machines, of which m1 runs a container."""

    async def views(self) -> list[MachineView]:
        return [machine_view(machine) for machine in self._cloud.known.values()]

    async def settings(self, machine: str) -> MachineSettings:
        return self._machine(machine).settings

    async def configure(self, machine: str, settings: MachineSettings) -> None:
        self._machine(machine).settings = settings

    async def remove(self, machine: str, force: bool = False) -> None:
        if self._machine(machine).containers and not force:
            raise Conflict(f"machine {machine!r} runs 1 containers: drain it first, or force its removal")
        del self._cloud.known[machine]

    async def admit(self, machine: str) -> None:
        self._cloud.known.setdefault(machine, Machine(machine, 2, 1 << 30, 1000))

    def _machine(self, machine: str) -> Machine:
        if machine not in self._cloud.known:
            raise NotFound("machine", machine, list(self._cloud.known))
        return self._cloud.known[machine]


class FakeContainers(FakePart):
    """Containers that the test says run."""

    async def views(self, user: str | None) -> list[ContainerView]:
        return [c for c in self._cloud.running if user in (None, c.user)]

    def of_robot(self, key: str) -> ContainerView | None:
        return next((c for c in self._cloud.running if robot_key(c.user, c.robot or "") == key), None)

    async def give_up(self, container: str) -> None:
        [gone] = [one for one in self._cloud.running if one.id == container]
        self._cloud.running.remove(gone)
        self._cloud.given_up.append(container)

    async def resize(self, container: str, cores: float) -> None:
        self._cloud.fail()
        self._cloud.running = [
            msgspec.structs.replace(one, cores=cores) if one.id == container else one for one in self._cloud.running
        ]


class FakePeople(FakePart):
    """People that the test says are seen."""

    async def views(self) -> list[PeopleGroupView]:
        return self._cloud.groups

    async def people(self, user: str, map_id: str) -> PeopleState:
        self._cloud.fail()
        if (user, map_id) not in self._cloud.people_states:
            raise Unavailable(f"no robot of user {user!r} tracks people on map {map_id!r} now")
        return self._cloud.people_states[user, map_id]

    async def counts(self, user: str, map_id: str, since: int) -> list[ZoneCount]:
        if (user, map_id) not in self._cloud.zone_counts:
            raise Unavailable(f"no robot of user {user!r} tracks people on map {map_id!r} now")
        return [count for count in self._cloud.zone_counts[user, map_id] if count.hour + 3600 > since]

    async def configure(self, user: str, map_id: str, settings: PeopleSettings) -> None:
        self._cloud.fail()
        self._cloud.people_settings.setdefault((user, map_id), []).append(settings)
        if not settings.history:
            self._cloud.zone_counts.pop((user, map_id), None)


class FakeTraffic(FakePart):
    """Traffic as the test sets it."""

    async def state(self, user: str, map_id: str) -> TrafficState:
        self._cloud.fail()
        if (user, map_id) not in self._cloud.traffic_states:
            raise Unavailable(f"no robot of user {user!r} takes part in the traffic of map {map_id!r} now")
        return self._cloud.traffic_states[user, map_id]

    async def take_out(self, user: str, map_id: str, robot: str) -> None:
        self._cloud.taken_out.add((user, map_id, await self._in_traffic(user, map_id, robot)))

    async def put_back(self, user: str, map_id: str, robot: str) -> None:
        self._cloud.taken_out.discard((user, map_id, await self._in_traffic(user, map_id, robot)))

    async def _in_traffic(self, user: str, map_id: str, robot: str) -> str:
        known = [one.robot for one in (await self.state(user, map_id)).robots]
        if robot not in known:
            raise NotFound("robot", robot, known)
        return robot


class FakeMaps(FakePart):
    """Maps in use, as the test sets it."""

    async def changed(self, head: MapRecord) -> None:
        self._cloud.changed_maps.append((head.id, head.version))

    async def end_groups(self, map_id: str) -> None:
        self._cloud.maps_without_groups.append(map_id)

    async def mapping_robots(self) -> list[MappingRobot]:
        return self._cloud.mapping

    async def lifelong_robots(self) -> list[LifelongRobot]:
        return self._cloud.lifelong


class FakeNodes(FakePart, RobotNodes):
    """Nodes of all robots, which answer as the test sets it."""

    async def homes(self, user: str, robot: str) -> list[NodeHome]:
        self._cloud.fail()
        return [NodeHome("move_base", "robot", "robot", -0.5, ["it is near"]), NodeHome("amcl")]

    async def run(self, user: str, robot: str, node: str, home: str) -> NodeHome:
        self._cloud.fail()
        return NodeHome(node, "cloud", home or "cloud", 0.5, ["the robot is weak"])

    async def observe(self, user: str, robot: str, seconds: float) -> Observations:
        if self._cloud.observations is None:
            raise Unavailable(f"robot {robot!r} has no container now: its nodes run while it is connected")
        self._cloud.observed.append((user, robot, seconds))
        return self._cloud.observations

    async def recorder(self, user: str, robot: str, service: str, request: Message) -> RecorderState:
        """Answer as the recorder of the robot; ``recorder`` is None: robots have no containers."""
        self._cloud.recorder_calls.append((user, robot, service, request))
        if self._cloud.recorder is None:
            raise Unavailable(f"robot {robot!r} has no container now")
        return self._cloud.recorder(service)

    async def map(self, user: str, robot: str, offset: int) -> GetPoseGraphResponse:
        self._cloud.fail()
        page = self._cloud.map_file[max(offset, 0) : offset + MAP_PAGE] if offset >= 0 else b""
        return GetPoseGraphResponse(base64.b64encode(page).decode(), len(self._cloud.map_file), 3, 2, 0)

    async def use_joint_map(self, user: str, robot: str, page: UseJointMapRequest) -> UseJointMapResponse:
        self._cloud.fail()
        so_far = self._cloud.joint_maps.get(robot, b"")[: page.offset] + base64.b64decode(page.data)
        self._cloud.joint_maps[robot] = so_far
        return UseJointMapResponse(9 if len(so_far) == page.size else 0)

    async def octomap(self, user: str, robot: str, request: GetOctomapFileRequest) -> GetOctomapFileResponse:
        self._cloud.octomaps_asked.append(request)
        page = self._cloud.octomap_file[request.offset : request.offset + MAP_PAGE]
        return GetOctomapFileResponse(base64.b64encode(page).decode(), len(self._cloud.octomap_file))


class FakePlanning(FakePart, Planning):
    """Answers every path request with the straight line from start to goal, or with an error."""

    async def compute_path(self, user: str, version: MapVersion, request: PathRequest) -> tuple[PathAnswer, Poses]:
        self._cloud.asked.append((user, version, request))
        self._cloud.fail()
        points = np.array([request.start[:2], request.goal[:2]])
        poses = poses_along(points, Pose2D(*request.goal).theta)
        length = float(np.linalg.norm(points[1] - points[0]))
        conditions = {"smooth": False, "bare_map": True, "robot_radius": 0.18}
        plan_id = hashlib.blake2b(repr((version, request)).encode(), digest_size=16).hexdigest()
        answer = PathAnswer(
            pack_poses(poses), 50.0, length, 2, 0.001, request.planner,
            self._cloud.reused or plan_id, "reused" if self._cloud.reused else "computed", self._cloud.reused or None,
            Raw(json.dumps(conditions)), "c9", 4711, version.id, version.version,
        )  # fmt: skip
        return answer, poses

    async def compute_costs(self, user: str, version: MapVersion, request: CostRequest) -> CostAnswer:
        """Answer with one cost for each goal but the first, to which there is no path; lengths are distances."""
        self._cloud.costs_asked.append((user, version, request))
        self._cloud.fail()
        row = [None, *[self._cloud.path_cost] * (len(request.goals) - 1)]
        rows: list[list[float | None]] = [row] * len(request.starts)
        if request.parameters.get("lengths"):
            rows = [[math.dist(start[:2], goal[:2]) for goal in request.goals] for start in request.starts]
        costs = Raw(json.dumps(rows))
        return CostAnswer(costs, 0.001, "c9", 4711, version.id, version.version)

    async def plan_fleet(self, user: str, version: MapVersion, request: FleetRequest) -> FleetAnswer:
        """Answer with robots that are at their goals already, without a step."""
        self._cloud.fleets_asked.append((user, version, request))
        self._cloud.fail()
        paths = Raw(json.dumps([[pose[:2]] for pose in request.starts]))
        times = Raw(json.dumps([[0.0] for _ in request.starts]))
        return FleetAnswer(
            paths, times, 0.5, 0.5 / request.speed, 0, 0, 0, 0, 0.001, "c9", 4711, version.id, version.version
        )


class FakeEndpoints(FakePart):
    """Endpoints that the test says serve."""

    async def views(self) -> list[EndpointView]:
        return self._cloud.serving


class FakeTasks(FakePart):
    """Notes whose tasks were changed."""

    async def changed(self, user: str, map_id: str) -> None:
        self._cloud.groups_with_changed_tasks.append((user, map_id))


class FakeMoves(FakePart):
    """Notes the robots that were moved to other maps."""

    async def moved(self, user: str, robot: str) -> None:
        self._cloud.fail()
        self._cloud.moved.append((user, robot))


class FakeDriver(FakePart):
    """Places of users, which end with their containers."""

    def set_limits(self, user: str, limits: Limits) -> None:
        self._cloud.quotas.set_limits(user, limits)

    async def close_places(self, user: str, reason: PPaaSError) -> None:
        self._cloud.running = [one for one in self._cloud.running if one.user != user]

    async def close_place(self, key: str, reason: PPaaSError) -> None:
        self._cloud.running = [one for one in self._cloud.running if robot_key(one.user, one.robot or "") != key]


class FakeCloud:
    """Parts of a master that answer as the test sets it; robots, users and quotas are the real ones."""

    def __init__(self) -> None:
        self.quotas = Quotas()
        self.places: dict[str, PlaceLink] = {}
        self.presence, self.counts = RobotPresence(self.place), ControlCounts()
        self.robots: RobotCalls = RobotNavigation(self)  # type: ignore[arg-type]  # it has the places that a driver has
        self.users: UserCalls = UserQuotas(FakeDriver(self), self.quotas)  # type: ignore[arg-type]
        self.machines: MachineCalls = FakeMachines(self)
        self.containers: ContainerCalls = FakeContainers(self)
        self.endpoints: NeighbourCalls = FakeEndpoints(self)
        self.people: PeopleCalls = FakePeople(self)
        self.traffic: TrafficCalls = FakeTraffic(self)
        self.tasks: TaskCalls = FakeTasks(self)
        self.stops: StopCalls = RobotStops(self, MemoryStore())
        self.maps: MapCalls = FakeMaps(self)
        self.moves: MoveCalls = FakeMoves(self)
        self.moved: list[tuple[str, str]] = []
        self.nodes: RobotNodes = FakeNodes(self)
        self.planning: Planning = FakePlanning(self)
        self.count_paths: CountPaths = partial(self.users.take_paths, ahead=0)
        self.robot_views, self.set_limits = self.robots.views, self.users.set_limits
        self.announced: list[tuple[str, str]] = []
        self.known_facts: dict[tuple[str, str, str], bytes] = {}
        """Facts about robots that other processes know, as JSON."""
        self.asked: list[tuple[str, MapVersion, PathRequest]] = []
        self.costs_asked: list[tuple[str, MapVersion, CostRequest]] = []
        self.path_cost = 50.0
        self.fleets_asked: list[tuple[str, MapVersion, FleetRequest]] = []
        self.error: Exception | None = None
        self.observations: Observations | None = None
        """Observations of every robot; None: robots have no containers."""
        self.recorder: Callable[[str], RecorderState] | None = None
        self.recorder_calls: list[tuple[str, str, str, Message]] = []
        self.observed: list[tuple[str, str, float]] = []
        self.map_file = b""
        self.octomap_file = b""
        self.octomaps_asked: list[GetOctomapFileRequest] = []
        self.mapping: list[MappingRobot] = []
        self.lifelong: list[LifelongRobot] = []
        self.joint_maps: dict[str, bytes] = {}
        """Bytes of the joint maps that robots have received so far."""
        self.running: list[ContainerView] = []
        self.known = {"m1": machine()}
        self.serving = [endpoint("local-1")]
        self.master_silence = 0.0
        self.start = READY
        self.given_up: list[str] = []
        self.changed_maps: list[tuple[str, str]] = []
        self.groups: list[PeopleGroupView] = []
        self.people_states: dict[tuple[str, str], PeopleState] = {}
        self.zone_counts: dict[tuple[str, str], list[ZoneCount]] = {}
        self.people_settings: dict[tuple[str, str], list[PeopleSettings]] = {}
        """Settings that each coordinator was configured with."""
        self.traffic_states: dict[tuple[str, str], TrafficState] = {}
        self.taken_out: set[tuple[str, str, str]] = set()
        self.maps_without_groups: list[str] = []
        self.groups_with_changed_tasks: list[tuple[str, str]] = []
        self.reused = ""
        """If set, id of the stored plan that every request returns."""

    def fail(self) -> None:
        """Raise the error that the test has set."""
        if self.error is not None:
            raise self.error

    def connect(self, user: str, robot: str, place: PlaceLink) -> None:
        """Connect a robot, with its place."""
        key = robot_key(user, robot)
        self.places[key] = place
        self.presence.came(key)

    def place(self, key: str) -> PlaceLink | None:
        return self.places.get(key)

    def request_of(self, key: str) -> PlaceRequest | None:
        """Return None: no robot has a clone."""
        return None

    def announce(self, kind: str, key: str) -> None:
        self.announced.append((kind, key))

    async def facts(self, kind: str, user: str, robot: str) -> list[bytes]:
        return [self.known_facts[kind, user, robot]] if (kind, user, robot) in self.known_facts else []
