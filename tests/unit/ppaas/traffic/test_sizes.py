"""Robots of several sizes in one traffic: small ones use lanes in which large ones have no room."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.fleet.stand_ins.robot import StandIn
from benchmarks.fleet.stand_ins.simulation import Simulation, roadmap_of
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.traffic.coordinator import TrafficCoordinator
from ppaas.traffic.room_in_cells import beside, nearest_in_cell
from ppaas.traffic.settings import TrafficParameters
from ppaas.traffic.sizes import with_size
from tests.support.budget import examples

SMALL, LARGE = 0.1, 0.2

LANES = """
............
..nnn..nnn..
..###..###..
..nnn..nnn..
............
..nnnnnnnn..
............
"""
"""Hall with lanes, marked by n, in which only small robots have room."""


def make(radii: Sequence[float], _: TrafficParameters) -> MetricRoadmap:
    """Return the cells of the hall for robots of some sizes."""
    rows = LANES.strip().split("\n")
    metric = roadmap_of(LANES.replace("n", "#") if min(radii) > SMALL else LANES)
    narrow = np.array([rows[row][column] == "n" for row, column in metric.roadmap.cells])
    barred = np.stack([narrow & (radius > SMALL) for radius in radii])
    return replace(metric, roadmap=replace(metric.roadmap, barred=barred), radii=tuple(radii))


def simulation_of(seed: int, **options: float) -> Simulation:
    """Return a simulation of the hall without robots."""
    simulation = Simulation(make((SMALL, LARGE), TrafficParameters()), seed, **options)
    simulation.coordinator = TrafficCoordinator(make, TrafficParameters())
    return simulation


def cell_at(simulation: Simulation, row: int, column: int) -> int:
    """Return the cell in a row and column of the hall."""
    return int(simulation.hall.roadmap.numbers[row, column])


def in_lane(simulation: Simulation, robot: StandIn) -> bool:
    """Return whether a robot is in a lane for small ones."""
    cell = simulation.hall.closest(robot.pose.x, robot.pose.y)
    return bool(simulation.hall.roadmap.barred[1, cell])


def test_small_robots_drive_through_narrow_lanes_and_large_ones_around() -> None:
    simulation = simulation_of(1)
    small = simulation.add(cell_at(simulation, 5, 1), cell_at(simulation, 5, 10), radius=SMALL)
    large = simulation.add(cell_at(simulation, 4, 1), cell_at(simulation, 4, 10), radius=LARGE)
    lane = 0
    while simulation.now < 60.0 and (small.goal_id or large.goal_id):
        simulation.step()
        lane += in_lane(simulation, small)
        assert not in_lane(simulation, large)
    assert (small.arrived, large.arrived) == (1, 1)
    assert lane > 50


def test_a_robot_that_takes_up_a_load_drives_around_narrow_lanes_from_then_on() -> None:
    simulation = simulation_of(1)
    robot = simulation.add(cell_at(simulation, 5, 1), cell_at(simulation, 5, 10), radius=SMALL)
    simulation.add(cell_at(simulation, 0, 0), radius=SMALL)
    simulation.run(60.0, until_home=True)
    assert robot.arrived == 1
    robot.radius = LARGE
    robot.way.give_back(robot.pose)  # as the next Move Base of its clone begins
    simulation.run(1.0)
    robot.head_for(*simulation.hall.centre(cell_at(simulation, 4, 1)), simulation.now)
    while simulation.now < 180.0 and robot.goal_id:
        simulation.step()
        assert not in_lane(simulation, robot)
    assert robot.arrived == 2


def test_a_goal_of_a_large_robot_in_a_narrow_lane_is_refused() -> None:
    simulation = simulation_of(2)
    simulation.add(cell_at(simulation, 0, 0), radius=SMALL)
    large = simulation.add(cell_at(simulation, 0, 11), cell_at(simulation, 5, 5), radius=LARGE)
    simulation.run(10.0)
    assert "no room for a robot" in large.refused[0]


def test_a_large_robot_joins_while_a_small_one_is_in_a_narrow_lane() -> None:
    simulation = simulation_of(3)
    small = simulation.add(cell_at(simulation, 5, 2), cell_at(simulation, 5, 9), radius=SMALL)
    simulation.add(cell_at(simulation, 0, 0), radius=SMALL)
    simulation.run(3.0)
    assert in_lane(simulation, small)
    large = simulation.add(cell_at(simulation, 0, 11), cell_at(simulation, 6, 11), radius=LARGE)
    simulation.run(60.0, until_home=True)
    assert (small.arrived, large.arrived) == (1, 1)
    assert not large.refused and simulation.nearest > 0.0


def test_a_large_robot_that_stands_in_a_narrow_lane_is_led_out() -> None:
    simulation = simulation_of(4)
    large = simulation.add(cell_at(simulation, 5, 5), cell_at(simulation, 0, 0), radius=LARGE)
    simulation.add(cell_at(simulation, 0, 11), radius=SMALL)
    simulation.run(60.0, until_home=True)
    assert large.arrived == 1


@settings(max_examples=examples(10))
@given(st.lists(st.sampled_from([SMALL, LARGE]), min_size=2, max_size=12), st.integers(0, 1000), st.floats(0.0, 0.5))
def test_nobody_touches_anybody_and_large_robots_stay_out_of_narrow_lanes(
    radii: list[float], seed: int, delay: float
) -> None:
    simulation = simulation_of(seed, delay=delay, loss=0.1, beside=0.3)
    wide = np.nonzero(~simulation.hall.roadmap.barred[1])[0].tolist()
    for cell, radius in zip(simulation.rng.sample(wide, len(radii)), radii, strict=True):
        simulation.add(cell, radius=radius)
    large = [robot for robot in simulation.robots if robot.radius == LARGE]
    for _ in range(600):
        outside = [robot for robot in large if not in_lane(simulation, robot)]
        simulation.step(again=True)
        by_grants = [robot for robot in outside if not (robot.way.free or robot.way.spur)]
        assert not any(in_lane(simulation, robot) for robot in by_grants)
    assert simulation.nearest > 0.0


@pytest.mark.parametrize(
    ("radii", "radius", "expected"),
    [
        ((), 0.2, (0.2,)),
        ((0.2,), 0.1, (0.1, 0.2)),
        ((0.1, 0.2), 0.2, (0.1, 0.2)),
        ((0.1, 0.2), 0.15, (0.1, 0.15, 0.2)),
        ((0.1, 0.15, 0.2), 0.12, (0.1, 0.15, 0.2)),
        ((0.1, 0.15, 0.2), 0.05, (0.05, 0.15, 0.2)),
        ((0.1, 0.15, 0.2), 0.5, (0.1, 0.2, 0.5)),
    ],
)
def test_three_sizes_are_told_apart(radii: tuple[float, ...], radius: float, expected: tuple[float, ...]) -> None:
    assert with_size(radii, radius) == expected


PLACES = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))


@given(PLACES, st.floats(0.3, 1.0), st.floats(0.0, 1.2))
def test_the_place_in_a_cell_is_the_nearest_one(place: tuple[float, float], spacing: float, radius: float) -> None:
    apart = beside(spacing, radius)
    x, y = nearest_in_cell(place, (0.5, -0.5), apart)
    assert max(abs(x - 0.5), abs(y + 0.5)) <= apart + 1e-12
    if max(abs(place[0] - 0.5), abs(place[1] + 0.5)) <= apart:
        assert (x, y) == place


@given(PLACES, PLACES, st.floats(0.1, 0.4), st.floats(0.0, 0.3))
def test_two_robots_in_cells_side_by_side_keep_a_margin(
    one: tuple[float, float], other: tuple[float, float], radius: float, margin: float
) -> None:
    spacing = 2.0 * (radius + margin)
    here, there = [
        nearest_in_cell(place, (x, 0.0), beside(spacing, radius)) for place, x in ((one, 0.0), (other, spacing))
    ]
    assert math.dist(here, there) >= 2.0 * radius + margin - 1e-9
