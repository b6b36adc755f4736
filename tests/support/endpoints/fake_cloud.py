"""Fake control plane without machines, with responses set by the test."""

import base64
import hashlib
import json
from collections.abc import Callable

import msgspec
import numpy as np
from msgspec import Raw

from engine.master.machine import Machine
from engine.master.places import robot_key
from engine.master.quotas import Quotas
from engine.service.links.place_link import PlaceLink
from engine.service.links.presence import RobotPresence
from engine.service.planning.fleet_requests import FleetAnswer, FleetRequest
from engine.service.planning.path_requests import CostAnswer, CostRequest, PathAnswer, PathRequest
from engine.service.planning.plan_rate import PlanRate
from engine.service.robot_navigation import RobotNavigation
from engine.service.view_building import machine_view
from engine.service.views import (
    ContainerView,
    EndpointView,
    GoalView,
    LifelongRobot,
    MachineView,
    MappingRobot,
    PeopleGroupView,
    RobotState,
    UserUsage,
)
from engine.specs.containers import ContainerSpec, MapVersion
from engine.specs.machine_settings import MachineSettings
from engine.specs.start_state import READY
from ppaas.diagnosis.observations.facts import Observations
from ppaas.errors import Conflict, NotFound, PPaaSError, Unavailable
from ppaas.geometry import Pose2D, poses_along
from ppaas.messages.base.message import Message
from ppaas.messages.fleet.traffic import TrafficState
from ppaas.messages.health.recorder import RecorderState
from ppaas.messages.octomap_msgs import GetOctomapFileRequest, GetOctomapFileResponse
from ppaas.messages.people_coordination import PeopleState, ZoneCount
from ppaas.messages.ppaas_msgs import NodeHome
from ppaas.messages.slam_toolbox import GetPoseGraphResponse, UseJointMapRequest, UseJointMapResponse
from ppaas.people.settings import PeopleSettings
from storage.records import Limits, MapRecord, User

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


class FakeCloud:
    """Answers every path request with the straight line from start to goal, or with an error."""

    def __init__(self) -> None:
        self.quotas = Quotas()
        self.plan_rate = PlanRate(self.quotas)
        self.places: dict[str, PlaceLink] = {}
        self.presence = RobotPresence(self.place)
        self.navigation = RobotNavigation(self)  # type: ignore[arg-type]  # it has the places that a driver has
        self.announced: list[tuple[str, str]] = []
        self.known_facts: dict[tuple[str, str, str], bytes] = {}
        """Facts about robots that other processes know, as JSON."""
        self.asked: list[tuple[str, MapVersion, PathRequest]] = []
        self.costs_asked: list[tuple[str, MapVersion, CostRequest]] = []
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

    async def machines(self) -> list[MachineView]:
        return [machine_view(machine) for machine in self.known.values()]

    async def endpoints(self) -> list[EndpointView]:
        return self.serving

    async def machine_settings(self, machine: str) -> MachineSettings:
        return self._machine(machine).settings

    async def configure_machine(self, machine: str, settings: MachineSettings) -> None:
        self._machine(machine).settings = settings

    async def remove_machine(self, machine: str, *, force: bool = False) -> None:
        if self._machine(machine).containers and not force:
            raise Conflict(f"machine {machine!r} runs 1 containers: drain it first, or force its removal")
        del self.known[machine]

    async def admit_machine(self, machine: str) -> None:
        self.known.setdefault(machine, Machine(machine, 2, 1 << 30, 1000))

    def _machine(self, machine: str) -> Machine:
        if machine not in self.known:
            raise NotFound("machine", machine, list(self.known))
        return self.known[machine]

    async def containers(self, user: str | None) -> list[ContainerView]:
        return [c for c in self.running if user in (None, c.user)]

    async def give_up_container(self, container: str) -> None:
        [gone] = [one for one in self.running if one.id == container]
        self.running.remove(gone)
        self.given_up.append(container)

    async def count_paths(self, user: str, paths: int) -> None:
        self.plan_rate.take(user, paths)

    async def check_container(self, user: str, cores: float) -> None:
        self.quotas.check_container(user, cores)

    async def usage(self, user: str) -> UserUsage:
        used = self.quotas.used(user)
        return UserUsage(used.containers, used.cores, self.plan_rate.used(user))

    def connect(self, user: str, robot: str, place: PlaceLink) -> None:
        """Let a robot be connected, with a place of its own."""
        key = robot_key(user, robot)
        self.places[key] = place
        self.presence.came(key)

    async def connected(self, robots: list[tuple[str, str]]) -> list[bool | None]:
        return [self.presence.is_here(robot_key(user, robot)) for user, robot in robots]

    async def robot_state(self, user: str, robot: str) -> RobotState:
        return await self.navigation.state(user, robot)

    async def send_goal(self, user: str, robot: str, pose: Pose2D) -> GoalView:
        return self.navigation.send_goal(user, robot, pose)

    async def goals(self, user: str, robot: str) -> list[GoalView]:
        return self.navigation.goals(user, robot)

    async def goal(self, user: str, robot: str, goal_id: str) -> GoalView:
        return self.navigation.goal(user, robot, goal_id)

    async def cancel_goal(self, user: str, robot: str, goal_id: str) -> GoalView:
        return self.navigation.cancel_goal(user, robot, goal_id)

    async def cancel_goals(self, user: str, robot: str) -> None:
        self.navigation.cancel_goals(user, robot)

    async def end_places(self, user: str, reason: PPaaSError, robot: str | None = None) -> None:
        self.running = [one for one in self.running if one.user != user or robot not in (None, one.robot)]

    def place(self, key: str) -> PlaceLink | None:
        return self.places.get(key)

    def set_limits(self, user: str, limits: Limits) -> None:
        self.quotas.set_limits(user, limits)

    def announce(self, kind: str, key: str) -> None:
        self.announced.append((kind, key))

    async def facts(self, kind: str, user: str, robot: str) -> list[bytes]:
        return [self.known_facts[kind, user, robot]] if (kind, user, robot) in self.known_facts else []

    def map_changed(self, head: MapRecord) -> None:
        self.changed_maps.append((head.id, head.version))

    async def resize_container(self, container: str, cores: float) -> None:
        if self.error is not None:
            raise self.error
        self.running = [
            msgspec.structs.replace(one, cores=cores) if one.id == container else one for one in self.running
        ]

    async def node_homes(self, user: str, robot: str) -> list[NodeHome]:
        if self.error is not None:
            raise self.error
        return [NodeHome("move_base", "robot", "robot", -0.5, ["it is near"]), NodeHome("amcl")]

    async def run_node(self, user: str, robot: str, node: str, home: str) -> NodeHome:
        if self.error is not None:
            raise self.error
        return NodeHome(node, "cloud", home or "cloud", 0.5, ["the robot is weak"])

    async def observe_robot(self, user: str, robot: str, seconds: float) -> Observations:
        if self.observations is None:
            raise Unavailable(f"robot {robot!r} has no container now: its nodes run while it is connected")
        self.observed.append((user, robot, seconds))
        return self.observations

    async def call_recorder(self, user: str, robot: str, service: str, request: Message) -> RecorderState:
        """Answer as the recorder of the robot; ``recorder`` is None: robots have no containers."""
        self.recorder_calls.append((user, robot, service, request))
        if self.recorder is None:
            raise Unavailable(f"robot {robot!r} has no container now")
        return self.recorder(service)

    async def robot_map(self, user: str, robot: str, offset: int) -> GetPoseGraphResponse:
        if self.error is not None:
            raise self.error
        page = self.map_file[max(offset, 0) : offset + MAP_PAGE] if offset >= 0 else b""
        return GetPoseGraphResponse(base64.b64encode(page).decode(), len(self.map_file), 3, 2, 0)

    async def mapping_robots(self) -> list[MappingRobot]:
        return self.mapping

    async def lifelong_robots(self) -> list[LifelongRobot]:
        return self.lifelong

    async def use_joint_map(self, user: str, robot: str, page: UseJointMapRequest) -> UseJointMapResponse:
        if self.error is not None:
            raise self.error
        self.joint_maps[robot] = self.joint_maps.get(robot, b"")[: page.offset] + base64.b64decode(page.data)
        return UseJointMapResponse(9 if len(self.joint_maps[robot]) == page.size else 0)

    async def people_groups(self) -> list[PeopleGroupView]:
        return self.groups

    async def people(self, user: str, map: str) -> PeopleState:  # noqa: A002
        if self.error is not None:
            raise self.error
        if (user, map) not in self.people_states:
            raise Unavailable(f"no robot of user {user!r} tracks people on map {map!r} now")
        return self.people_states[user, map]

    async def people_counts(self, user: str, map: str, since: int) -> list[ZoneCount]:  # noqa: A002
        if (user, map) not in self.zone_counts:
            raise Unavailable(f"no robot of user {user!r} tracks people on map {map!r} now")
        return [count for count in self.zone_counts[user, map] if count.hour + 3600 > since]

    async def configure_people(self, user: str, map: str, settings: PeopleSettings) -> None:  # noqa: A002
        if self.error is not None:
            raise self.error
        self.people_settings.setdefault((user, map), []).append(settings)
        if not settings.history:
            self.zone_counts.pop((user, map), None)

    async def traffic(self, user: str, map: str) -> TrafficState:  # noqa: A002
        if self.error is not None:
            raise self.error
        if (user, map) not in self.traffic_states:
            raise Unavailable(f"no robot of user {user!r} takes part in the traffic of map {map!r} now")
        return self.traffic_states[user, map]

    async def take_out(self, user: str, map: str, robot: str) -> None:  # noqa: A002
        self.taken_out.add((user, map, await self._in_traffic(user, map, robot)))

    async def put_back(self, user: str, map: str, robot: str) -> None:  # noqa: A002
        self.taken_out.discard((user, map, await self._in_traffic(user, map, robot)))

    async def _in_traffic(self, user: str, map_id: str, robot: str) -> str:
        known = [one.robot for one in (await self.traffic(user, map_id)).robots]
        if robot not in known:
            raise NotFound("robot", robot, known)
        return robot

    async def tasks_changed(self, user: str, map: str) -> None:  # noqa: A002
        self.groups_with_changed_tasks.append((user, map))

    async def end_groups(self, map: str) -> None:  # noqa: A002
        self.maps_without_groups.append(map)

    async def robot_octomap(self, user: str, robot: str, request: GetOctomapFileRequest) -> GetOctomapFileResponse:
        self.octomaps_asked.append(request)
        page = self.octomap_file[request.offset : request.offset + MAP_PAGE]
        return GetOctomapFileResponse(base64.b64encode(page).decode(), len(self.octomap_file))

    async def compute_path(self, user: User, map: MapVersion, request: PathRequest) -> PathAnswer:  # noqa: A002
        self.asked.append((user.id, map, request))
        if self.error is not None:
            raise self.error
        points = np.array([request.start[:2], request.goal[:2]])
        poses = poses_along(points, Pose2D(*request.goal).theta)
        length = float(np.linalg.norm(points[1] - points[0]))
        conditions = {"smooth": False, "bare_map": True, "robot_radius": 0.18}
        plan_id = hashlib.blake2b(repr((map, request)).encode(), digest_size=16).hexdigest()
        return PathAnswer(
            poses, 50.0, length, 2, 0.001, request.planner,
            self.reused or plan_id, "reused" if self.reused else "computed", self.reused or None,
            Raw(json.dumps(conditions)), "c9", 4711, map.id, map.version,
        )  # fmt: skip

    async def compute_costs(self, user: User, map: MapVersion, request: CostRequest) -> CostAnswer:  # noqa: A002
        """Answer with cost 50 for each goal except the first, to which there is no path."""
        self.costs_asked.append((user.id, map, request))
        if self.error is not None:
            raise self.error
        row = [None if number == 0 else 50.0 for number in range(len(request.goals))]
        costs = Raw(json.dumps([row] * len(request.starts)))
        return CostAnswer(costs, 0.001, "c9", 4711, map.id, map.version)

    async def plan_fleet(self, user: User, map: MapVersion, request: FleetRequest) -> FleetAnswer:  # noqa: A002
        """Answer with robots that are at their goals already, without a step."""
        self.fleets_asked.append((user.id, map, request))
        if self.error is not None:
            raise self.error
        paths = Raw(json.dumps([[pose[:2]] for pose in request.starts]))
        times = Raw(json.dumps([[0.0] for _ in request.starts]))
        return FleetAnswer(paths, times, 0.5, 0.5 / request.speed, 0, 0, 0, 0, 0.001, "c9", 4711, map.id, map.version)
