"""Plans of fleets, by the planner server."""

import itertools
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.fleet.checking import faults_of
from ppaas.clone.planning_container import build_planning
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import (
    GoalOccupied,
    GoalOutsideMap,
    InvalidInput,
    NoValidPath,
    PlanCancelled,
    PlanTimeout,
    PPaaSError,
    StartOccupied,
    StartOutsideMap,
)
from ppaas.fleet.lattice_roadmap import lattice_roadmap
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.robot_sizes import RobotSizes, clearance_of
from ppaas.maps.grid import UNKNOWN
from ppaas.messages.codec import decode, encode
from ppaas.messages.fleet.fleet_plans import ComputeFleetPlanRequest, ComputeFleetPlanResponse
from ppaas.nodes.graph import Graph
from ppaas.nodes.planner_server import fleet_service
from ppaas.nodes.planner_server.fleet_service import MAX_ROBOTS, MAX_SECONDS, MAX_TURN
from ppaas.polygons import distances_to_edges
from ppaas.zones.shapes import LineString
from ppaas.zones.zone import Capacity, Lane, OneWay, Zone, ZoneSet
from tests.reference.fleet import searches, timing
from tests.support.world.planar_world import walled_map
from tests.support.zones import rectangle

LAYERS = build_layers(walled_map(6, 4, [(2.9, 0.0, 3.1, 2.5)]))
PARTED = build_layers(walled_map(6, 4, [(2.9, 0.0, 3.1, 4.0)]))
Places = Sequence[tuple[float, ...]]
STARTS: Places = [(1.0, 1.0), (5.0, 1.0), (1.0, 3.0), (5.0, 3.0)]
GOALS: Places = [(5.0, 1.0), (1.0, 1.0), (5.0, 3.0), (1.0, 3.0)]
RADIUS, MARGIN = 0.15, 0.05


def planned(starts: Places = STARTS, goals: Places = GOALS, layers=LAYERS, **fields: Any) -> Any:
    graph, answers = Graph(), list[Any]()
    build_planning(graph, layers)
    ends = ([number for place in places for number in place] for places in (starts, goals))
    graph.call("compute_fleet_plan", ComputeFleetPlanRequest(*ends, **{"radius": RADIUS, **fields}), answers.append)
    (answer,) = answers
    return answer


def checked(answer: Any, starts: Places, goals: Places) -> NDArray[np.float64]:
    """Return the paths of an answer, (n, t, 2) float64, whose plan was checked on a roadmap of its own."""
    if isinstance(answer, PPaaSError):
        raise answer
    metric = lattice_roadmap(clearance_of(LAYERS), LAYERS.grid.info, RobotSizes(RADIUS, MARGIN))
    paths = np.array(json.loads(answer.paths))
    steps = np.array([[cell_of(metric, *place) for place in path] for path in paths.tolist()], np.int32).T
    ends = [[cell_of(metric, *place) for place in places] for places in (starts, goals)]
    plan = FleetPlan(steps, answer.bound)
    assert faults_of(metric.roadmap, plan, *ends) == []
    assert (plan.cost, plan.makespan, metric.spacing) == (answer.cost, answer.makespan, answer.spacing)
    assert answer.bound <= answer.cost
    return paths


def cell_of(metric: MetricRoadmap, x: float, y: float) -> int:
    return metric.nearest(x, y, metric.spacing)


@pytest.mark.parametrize("seconds", [0.0, 0.2])
def test_paths_lead_from_cell_to_cell_without_conflicts(seconds: float) -> None:
    answer = decode(ComputeFleetPlanResponse, encode(planned(seconds=seconds, speed=0.8)))
    paths = checked(answer, STARTS, GOALS)
    assert answer.step_seconds == pytest.approx(answer.spacing / 0.8)
    assert paths.shape == (4, answer.makespan + 1, 2)
    assert np.hypot(*(paths[:, 0] - STARTS).T).max() <= 0.75 * answer.spacing
    assert np.hypot(*(paths[:, -1] - GOALS).T).max() <= 0.75 * answer.spacing
    assert answer.seconds >= seconds or answer.cost == answer.bound


def test_robots_that_never_share_a_cell_keep_their_diameter_apart_at_each_step() -> None:
    paths = checked(planned(), STARTS, GOALS)
    for one in range(4):
        for other in range(one):
            assert np.hypot(*(paths[one] - paths[other]).T).min() >= 2 * (RADIUS + MARGIN) - 2e-3


def test_times_are_those_of_robots_with_speeds_of_their_own_that_take_time_to_turn() -> None:
    speeds, turn = [0.25, 0.5, 1.0, 2.0], 0.75
    answer = planned(speeds=speeds, turn_seconds=turn)
    paths, times = checked(answer, STARTS, GOALS), json.loads(answer.times)
    metric = lattice_roadmap(clearance_of(LAYERS), LAYERS.grid.info, RobotSizes(RADIUS, MARGIN))
    steps = [[cell_of(metric, *place) for place in row] for row in paths.swapaxes(0, 1).tolist()]
    moves = [answer.spacing / speed for speed in speeds]
    twin = np.array(timing.times(metric.roadmap, steps, moves, turn))
    assert pytest.approx(twin, abs=1e-3) == np.array(times).T
    assert answer.turns == sum(searches.count(metric.roadmap, path) for path in np.array(steps).T.tolist())
    assert answer.step_seconds == pytest.approx(answer.spacing / 0.25)


def test_an_improved_plan_has_fewer_turns_where_they_take_time() -> None:
    assert planned(seconds=0.2, turn_seconds=5.0, seed=2).turns <= planned(seconds=0.2, seed=2).turns


def test_the_same_seed_gives_the_same_plan_also_on_a_roadmap_that_is_kept() -> None:
    assert planned(seed=3).paths == planned(seed=3).paths
    graph, answers = Graph(), list[Any]()
    build_planning(graph, LAYERS)
    ends = ([number for place in places for number in place] for places in (STARTS, GOALS))
    request = ComputeFleetPlanRequest(*ends, RADIUS, seed=3)
    for _ in range(2):
        graph.call("compute_fleet_plan", request, answers.append)
    assert answers[0].paths == answers[1].paths == planned(seed=3).paths


def test_paths_lead_along_lanes_if_the_map_has_any() -> None:
    around = Zone(LineString([[1, 1], [1, 3], [5, 3], [5, 1]]), Lane(name="around"))
    bay = Zone(LineString([[2, 3], [2, 1.5]]), Lane(name="bay"))
    layers = replace(LAYERS, zones=ZoneSet([around, bay]))
    answer = planned([(1, 1), (5, 1)], [(5, 1), (1, 1)], layers, seconds=0.1, turn_seconds=1.0, speed=0.5)
    if isinstance(answer, PPaaSError):
        raise answer
    paths, times = np.array(json.loads(answer.paths)), np.array(json.loads(answer.times))
    for path, own in zip(paths, times, strict=True):
        lines = np.array([[1, 1, 1, 3], [1, 3, 5, 3], [5, 3, 5, 1], [2, 3, 2, 1.5]], np.float64)
        assert distances_to_edges(lines[:, :2], lines[:, 2:], path[:, np.newaxis]).min(axis=1).max() < 1e-3
        lengths = np.hypot(*np.diff(path, axis=0).T)
        moved = lengths > 0.0
        assert lengths[moved].min() >= answer.spacing - 2e-3
        assert (np.diff(own)[moved] >= lengths[moved] / 0.5 - 2e-3).all()
        assert answer.step_seconds >= lengths.max() / 0.5 - 2e-3
    assert answer.turns >= 6, "around two corners, and in and out of the bay"


def test_goals_beside_lanes_and_lanes_too_near_are_refused_with_the_reason() -> None:
    one, other = (Zone(LineString([[1, y], [5, y]]), Lane(name=name)) for name, y in (("one", 3.0), ("other", 3.3)))
    with pytest.raises(GoalOccupied, match=r"the goal of robot 0, 5, 1, has no cell within 0\.3 m"):
        raise planned([(1, 3)], [(5, 1)], replace(LAYERS, zones=ZoneSet([one])))
    with pytest.raises(InvalidInput, match=r"lanes 'one' and 'other' are 0\.30 m apart"):
        raise planned([(1, 3)], [(5, 3)], replace(LAYERS, zones=ZoneSet([one, other])))


def test_no_robots_have_no_paths_and_robots_at_their_goals_stay() -> None:
    nothing = planned([], [], seconds=0.1, turn_seconds=1.0)
    assert json.loads(nothing.paths) == json.loads(nothing.times) == []
    answer = planned(STARTS, STARTS)
    assert checked(answer, STARTS, STARTS).shape == (4, 1, 2)
    assert (answer.cost, answer.makespan, answer.turns) == (0, 0, 0)
    assert json.loads(answer.times) == [[0.0]] * 4


@pytest.mark.parametrize(
    ("fields", "error", "text"),
    [
        ({"starts": STARTS[:3]}, InvalidInput, "there are 3 starts and 4 goals; give as many of both"),
        ({"starts": [(9.0, 1.0), *STARTS[1:]]}, StartOutsideMap, "the start of robot 0, 9, 1, is outside the map"),
        ({"goals": [*GOALS[:3], (1.0, -3.0)]}, GoalOutsideMap, "the goal of robot 3, 1, -3, is outside the map"),
        (
            {"starts": [*STARTS[:2], (3.0, 1.0), STARTS[3]]},
            StartOccupied,
            "start of robot 2, 3, 1, is 0 m from an obst",
        ),
        ({"goals": [GOALS[0], (2.8, 1.0), *GOALS[2:]]}, GoalOccupied, "a robot needs 0.15 m: move the goal"),
        ({"starts": [*STARTS[:3], (1.0, 1.01)]}, InvalidInput, "the starts of robots 0 and 3 are in one cell, at "),
        ({"goals": [*GOALS[:3], (5.0, 1.01)]}, InvalidInput, "cells are 0.4 m wide: move one of them"),
        ({"layers": PARTED}, NoValidPath, "robot 0 cannot reach its goal, not even without other robots: a smaller"),
        ({"radius": 3.0}, InvalidInput, "a robot of radius 3 m with a margin of 0.05 m fits nowhere on the map"),
        ({"radius": 0.0}, InvalidInput, "the radius must be a positive number"),
        ({"radius": 1e-5, "margin": 0.0}, InvalidInput, "the map is too large for robots so small"),
        ({"margin": -0.1}, InvalidInput, "the margin must be at least 0 m"),
        ({"speed": 0.0}, InvalidInput, "speed must be finite and at least 0.001 m/s"),
        ({"speed": math.inf}, InvalidInput, "speed must be finite"),
        ({"speeds": [1.0] * 3}, InvalidInput, "there are 3 speeds and 4 starts; give one speed a robot"),
        ({"speeds": [1.0, 0.0, 1.0, -1.0]}, InvalidInput, "speed of robot 1 must be finite and at least 0.001 m/s"),
        ({"speeds": [1.0, 1.0, 1.0, math.nan]}, InvalidInput, "the speed of robot 3 must be finite"),
        ({"turn_seconds": -0.1}, InvalidInput, f"turn_seconds must be from 0 to {MAX_TURN:g}, not -0.1"),
        ({"turn_seconds": math.inf}, InvalidInput, "turn_seconds must be from 0"),
        ({"seconds": 11.0}, InvalidInput, f"seconds of improvement must be from 0 to {MAX_SECONDS:g}, not 11"),
        ({"seconds": math.nan}, InvalidInput, "seconds of improvement must be"),
        ({"seed": -1}, InvalidInput, "seed must be at least 0"),
        ({"timeout": 0.0}, InvalidInput, "timeout must be above 0"),
        ({"timeout": 1e-6}, PlanTimeout, "no path found within"),
        (
            {"starts": [(math.nan, 1.0)]},
            InvalidInput,
            "the start of robot 0 must be finite x, y in metres",
        ),
        ({"starts": [*STARTS, (1.0,)]}, InvalidInput, "starts must have x and y for each robot, not 9 numbers"),
        ({"goals": [(1.0, 1.0)] * (MAX_ROBOTS + 1)}, InvalidInput, f"at most {MAX_ROBOTS} goals, not {MAX_ROBOTS + 1}"),
    ],
)
def test_a_request_that_cannot_be_served_is_a_typed_error_with_the_robot(
    fields: dict[str, Any], error: type[PPaaSError], text: str
) -> None:
    answer = planned(**fields)
    assert isinstance(answer, error)
    assert text in str(answer)


def test_robots_that_cannot_pass_each_other_get_an_error() -> None:
    corridor = build_layers(walled_map(4, 0.7, []))
    answer = planned([(0.5, 0.35), (3.5, 0.35)], [(3.5, 0.35), (0.5, 0.35)], corridor)
    assert isinstance(answer, NoValidPath)
    assert "cannot pass each other" in str(answer)


def test_unknown_parts_are_no_way_and_no_place() -> None:
    grid = walled_map(6, 4, [])
    grid.data[:, 55:65] = UNKNOWN
    answer = planned(layers=build_layers(grid))
    assert isinstance(answer, NoValidPath)
    assert isinstance(planned([(3.0, 1.0)], [(1.0, 1.0)], build_layers(grid)), StartOccupied)


def test_the_time_limit_ends_the_improvement_and_not_the_plan() -> None:
    answer = planned(seconds=10.0, timeout=0.5)
    checked(answer, STARTS, GOALS)
    assert answer.seconds < 5.0


@pytest.mark.parametrize(("name", "most"), [("MAX_PLACES", 10), ("MAX_SCHEDULE", 10)])
def test_plans_that_are_too_large_are_refused_or_not_improved(
    monkeypatch: pytest.MonkeyPatch, name: str, most: int
) -> None:
    monkeypatch.setattr(fleet_service, name, most)
    answer = planned(seconds=0.2)
    if name == "MAX_PLACES":
        assert isinstance(answer, InvalidInput)
        assert "a plan of 4 robots and" in str(answer)
    else:
        assert answer.paths == planned().paths
        checked(answer, STARTS, GOALS)


@pytest.mark.parametrize("after", [0, 3, 60])
def test_a_request_can_be_cancelled_at_any_time(after: int) -> None:
    context = _Context(after)
    answers = list[Any]()
    ends = ([number for place in places for number in place] for places in (STARTS, GOALS))
    service = fleet_service.FleetService(context, LAYERS)  # type: ignore[arg-type]
    service.compute(ComputeFleetPlanRequest(*ends, RADIUS, seconds=10.0), answers.append)
    assert isinstance(answers[0], PlanCancelled)
    assert context.asked == after + 1


class _Context:
    """Runs a job at once, and cancels it when it has asked so many times whether it is cancelled."""

    def __init__(self, after: int) -> None:
        self._after = after
        self.asked = 0

    def now(self) -> float:
        return 0.0

    def _cancelled(self) -> bool:
        self.asked += 1
        return self.asked > self._after

    def start(self, work: Callable[[Callable[[], bool]], Any], done: Callable[[Any], None]) -> None:
        try:
            done(work(self._cancelled))
        except PPaaSError as error:
            done(error)


def test_robots_obey_the_zones_of_the_map() -> None:
    zones = [
        rectangle(OneWay(name="east", direction=0.0), 2.2, 2.6, 3.8, 3.2),
        rectangle(Capacity(name="dock", robots=1), 0.0, 0.0, 1.5, 1.5),
    ]
    layers = replace(LAYERS, zones=ZoneSet(zones))  # type: ignore[arg-type]
    paths = checked(planned(layers=layers), STARTS, GOALS)
    for path in paths:
        for (x, y), (to_x, to_y) in itertools.pairwise(path.tolist()):
            against = 2.2 < (x + to_x) / 2 < 3.8 and 2.6 < (y + to_y) / 2 < 3.2 and to_x < x
            assert not against
    dock = zones[1].area
    inside = [(dock.distances(paths[:, step]) < RADIUS).sum() for step in range(paths.shape[1])]
    assert max(inside) == 1
