"""Paths, and plans of fleets, on their way to a planning container, whose nodes are real and whose link is played."""

from collections.abc import Callable
from typing import Any, cast

import msgspec
import numpy as np
import pytest

from benchmarks.fleet.checking import faults_of
from engine.control.planning.planning import ANSWER_MARGIN, Planning
from engine.control.planning.requests import FleetRequest
from engine.links.place_link import PlaceLink
from engine.specs.containers import MapVersion
from engine.specs.start_state import KERNEL_PATIENCE
from ppaas.clone.planning_container import build_planning
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import PPaaSError, StartOccupied
from ppaas.fleet.lattice_roadmap import lattice_roadmap
from ppaas.fleet.plan import FleetPlan, timing_of, turns_of
from ppaas.fleet.robot_sizes import RobotSizes, clearance_of
from ppaas.geometry import quaternion_of
from ppaas.messages import decode, encode
from ppaas.nodes.graph import Graph
from ppaas.plans.path_service import PathRequest
from tests.support.world.planar_world import walled_map

MAP = MapVersion("house", "v")
LAYERS = build_layers(walled_map(6, 4, [(2.9, 0.0, 3.1, 2.5)]))
REQUEST = FleetRequest(
    ((1.0, 1.0), (5.0, 1.0, 0.5)), ((5.0, 1.0), (1.0, 1.0)), 0.15, speeds=(0.8, 1.6), turn_seconds=1.5, seed=3
)


class _Place:
    """A place whose container is in this process."""

    container, pid = "c1", 4711

    def __init__(self) -> None:
        self.asked: list[tuple[str, float]] = []

    async def ready(self, timeout: float, why: Callable[[], PPaaSError | None]) -> None:
        assert timeout > 0.0

    async def call(self, service: str, request: bytes, timeout: float) -> bytes:
        self.asked.append((service, timeout))
        graph, answers = Graph(), list[Any]()
        build_planning(graph, LAYERS)
        graph.call(service, decode(graph.service(service).type.request, request), answers.append)
        if isinstance(answers[0], PPaaSError):
            raise answers[0]
        return encode(answers[0])


@pytest.fixture
def place() -> _Place:
    return _Place()


@pytest.fixture
def planning(place: _Place) -> Planning:
    async def use(user: str, version: MapVersion, labels: dict[str, str], queue: bool) -> tuple[PlaceLink, None]:
        assert (user, version, labels, queue) == ("ann", MAP, {}, False)
        return cast("PlaceLink", place), None

    return Planning(use)


async def test_the_answer_is_a_valid_plan_with_map_and_container(planning: Planning, place: _Place) -> None:
    answer = await planning.plan_fleet("ann", MAP, REQUEST)
    assert place.asked == [("compute_fleet_plan", REQUEST.timeout + KERNEL_PATIENCE + ANSWER_MARGIN)]
    told = msgspec.json.decode(msgspec.json.encode(answer))
    assert (told["map"], told["version"], told["container"], told["pid"]) == ("house", "v", "c1", 4711)
    assert told["step_seconds"] == pytest.approx(told["spacing"] / 0.8)
    metric = lattice_roadmap(clearance_of(LAYERS), LAYERS.grid.info, RobotSizes(0.15, 0.05))
    steps = np.array([[metric.nearest(*place, 0.01) for place in path] for path in told["paths"]], np.int32).T
    ends = [[metric.nearest(*pose[:2], 0.3) for pose in poses] for poses in (REQUEST.starts, REQUEST.goals)]
    plan = FleetPlan(steps, told["bound"])
    assert faults_of(metric.roadmap, plan, *ends) == []
    assert (plan.cost, plan.makespan) == (told["cost"], told["makespan"])
    assert told["turns"] == turns_of(metric.roadmap, plan).sum()
    moves = told["spacing"] / np.array(REQUEST.speeds)
    times = timing_of(metric.roadmap, plan, moves, 1.5).times
    assert pytest.approx(times, abs=1e-3) == np.array(told["times"]).T


async def test_errors_of_the_container_keep_their_class(planning: Planning) -> None:
    with pytest.raises(StartOccupied, match="the start of robot 1, 3, 1, is 0 m from an obstacle"):
        await planning.plan_fleet("ann", MAP, msgspec.structs.replace(REQUEST, starts=((1.0, 1.0), (3.0, 1.0))))


async def test_a_path_has_the_poses_of_the_planner_and_its_container(planning: Planning, place: _Place) -> None:
    request = PathRequest((1.0, 1.0), (5.0, 1.0, 0.5), "theta_star", parameters={"robot_radius": 0.1}, timeout=3.0)
    answer, poses = await planning.compute_path("ann", MAP, request)
    assert place.asked == [("compute_packed_path", 3.0 + KERNEL_PATIENCE + ANSWER_MARGIN)]
    assert (answer.container, answer.pid, answer.map, answer.version) == ("c1", 4711, "house", "v")
    assert (answer.planner, answer.origin, answer.reused) == ("theta_star", "computed", None)
    assert poses[0].tolist() == [1.0, 1.0, 0.0, *poses[0, 3:].tolist()]
    assert poses[-1] == pytest.approx([5.0, 1.0, 0.0, *quaternion_of(0.5)])
    assert np.hypot(*np.diff(poses[:, :2], axis=0).T).sum() == pytest.approx(answer.length)
    assert msgspec.json.decode(answer.conditions)["robot_radius"] == 0.1
