"""Traffic along lanes that were drawn: robots keep to them, touch nobody, and reach their goals."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from benchmarks.fleet.stand_ins.robot import StandIn
from benchmarks.fleet.stand_ins.simulation import Simulation
from ppaas.errors import InvalidInput
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.polygons import distances_to_edges
from ppaas.traffic.coordinator import TrafficCoordinator, state_of
from ppaas.traffic.settings import TrafficParameters
from ppaas.zones.shapes import LineString
from ppaas.zones.zone import Lane, Zone
from tests.support.fleet.lanes import SITE, SPACING, hall, line

CELLS = hall(*SITE)
PARALLEL = hall(line((1, 1), (9, 1), (9, 2), (1, 2), (1, 1)))
ZONE = Zone(LineString([[1.0, 6.0], [19.0, 6.0]]), Lane(name="main"))


def coordinator_of(simulation: Simulation) -> TrafficCoordinator:
    assert simulation.coordinator is not None
    return simulation.coordinator


def off_lanes(robots: Sequence[StandIn], cells: MetricRoadmap) -> float:
    """Return the largest distance of robots from all moves [m]."""
    begins, ends = cells.centres[cells.roadmap.moves.T]
    places = np.array([[robot.pose[:2]] for robot in robots])
    return float(distances_to_edges(begins, ends, places).min(axis=1).max())


@pytest.mark.parametrize("seed", range(4))
def test_robots_drive_along_lanes_to_all_goals_and_touch_nobody(seed: int) -> None:
    simulation = Simulation(CELLS, seed, 0.3)
    for cell in simulation.rng.sample(simulation.cells, 8):
        simulation.add(cell)
    for _ in range(3000):
        simulation.step(again=True)
        assert off_lanes(simulation.robots, CELLS) < 0.25 * SPACING
    assert simulation.nearest > 0.0
    assert simulation.deadlocks == 0
    assert sum(robot.arrived for robot in simulation.robots) > 15


def test_goals_beside_lanes_are_reached() -> None:
    simulation = Simulation(CELLS, 3, beside=0.45)
    for cell in simulation.rng.sample(simulation.cells, 5):
        simulation.add(cell)
    simulation.run(300.0, again=True)
    assert simulation.nearest > 0.0
    misses = [miss for robot in simulation.robots for miss in robot.misses]
    assert len(misses) > 15
    assert np.median(misses) < 0.1


def test_a_robot_that_is_alone_keeps_to_the_lanes() -> None:
    simulation = Simulation(CELLS, 1)
    coordinator_of(simulation).occupancy.use_zones([ZONE])
    robot = simulation.put(1.0, 6.0)
    robot.head_for(6.0, 11.0, 0.0)
    farthest = 0.0
    while simulation.now < 60.0 and robot.goal_id:
        simulation.step()
        farthest = max(farthest, off_lanes([robot], CELLS))
    assert robot.misses == [pytest.approx(0.0, abs=0.1)]
    assert farthest < 0.25 * SPACING


def test_a_goal_that_is_far_from_all_lanes_is_refused_with_the_reason() -> None:
    simulation = Simulation(CELLS, 1)
    robot = simulation.put(1.0, 6.0)
    simulation.put(19.0, 6.0)
    robot.head_for(17.0, 11.0, 0.0)
    simulation.run(20.0, until_home=True)
    assert robot.refused and "there is no lane with room for the robot within 0.45 m" in robot.refused[0]


@pytest.mark.parametrize("beside", [0.1, 0.2, 0.3, 0.45])
def test_robots_whose_goals_are_between_two_lanes_do_not_touch_there(beside: float) -> None:
    simulation = Simulation(PARALLEL, 1)
    one, other = simulation.put(4.0, 1.0), simulation.put(4.0, 2.0)
    simulation.run(3.0)
    one.head_for(5.0, 1.0 + beside, simulation.now)
    other.head_for(5.0, 2.0 - beside, simulation.now)
    simulation.run(60.0, until_home=True)
    assert (one.goal_id, other.goal_id) == ("", "")
    assert simulation.nearest > 0.05
    assert min(*one.misses, *other.misses) < 0.1, "one of them reaches its goal"


def test_robots_drive_to_lanes_past_each_other() -> None:
    simulation = Simulation(PARALLEL, 1)
    robots = [simulation.put(*place) for place in ((3.0, 3.0), (3.5, 3.0), (3.25, 2.5), (2.7, 2.5))]
    simulation.run(2.0)
    for number, robot in enumerate(robots):
        robot.head_for(8.0 - number, 1.0, simulation.now)
    simulation.run(120.0, until_home=True)
    assert all(robot.misses for robot in robots)
    assert simulation.nearest > 0.0


def test_a_robot_that_is_far_from_all_lanes_is_told_so() -> None:
    simulation = Simulation(PARALLEL, 1)
    simulation.put(4.0, 1.0)
    far = simulation.put(4.0, 6.0)
    far.head_for(6.0, 1.0, 0.0)
    simulation.run(10.0)
    assert far.pose[:2] == (4.0, 6.0)
    why = "the robot is farther than 1.2 m from where robots of the traffic drive"
    assert far.refused and set(far.refused) == {why}
    shown = {each.robot: each for each in state_of(coordinator_of(simulation), 0.0, simulation.now, 0.0).robots}
    assert (shown[far.name].state, shown[far.name].waits_for) == ("no_cells", why)
    assert shown["tb0"].state == "idle"


def test_robots_go_on_with_other_lanes() -> None:
    simulation = Simulation(CELLS, 5)
    for cell in simulation.rng.sample(simulation.cells, 6):
        simulation.add(cell)
    simulation.run(40.0, again=True)
    others = hall(*SITE[:3], line((10, 6), (10, 11), name="new"), *SITE[4:])
    coordinator_of(simulation).occupancy.use_map(lambda *_: others)
    simulation.hall, simulation.cells = others, list(range(len(others.roadmap)))
    arrived = simulation.arrived
    simulation.run(200.0, again=True)
    assert simulation.nearest > 0.0
    assert simulation.arrived > arrived + 5


def test_lanes_without_room_stop_all_robots_with_the_reason_until_they_are_drawn_anew() -> None:
    def wrong(_: Sequence[float], __: TrafficParameters) -> MetricRoadmap:
        raise InvalidInput("lanes 'a' and 'b' are 0.41 m apart")

    simulation = Simulation(CELLS, 5)
    robots = [simulation.add(cell) for cell in simulation.rng.sample(simulation.cells, 4)]
    simulation.run(20.0, again=True)
    occupancy = coordinator_of(simulation).occupancy
    occupancy.use_map(wrong)
    simulation.run(5.0)
    places = [robot.pose[:2] for robot in robots]
    late = simulation.put(13.0, 2.5)
    for robot in (*robots, late):
        robot.head_for(6.0, 8.0, simulation.now)
    simulation.run(5.0)
    assert [robot.pose[:2] for robot in robots] == places, "nobody drives"
    assert all("0.41 m apart" in robot.refused[-1] for robot in (*robots, late))
    occupancy.use_map(lambda *_: CELLS)
    simulation.run(2.0)
    before = [math.dist(robot.pose[:2], (6.0, 8.0)) for robot in robots]
    for robot in robots:
        robot.head_for(6.0, 8.0, simulation.now)
    simulation.run(100.0)
    assert any(math.dist(robot.pose[:2], (6.0, 8.0)) < 0.2 for robot in robots), before
    assert simulation.nearest > 0.0


def test_a_first_robot_for_which_the_lanes_are_wrong_is_told_and_stands() -> None:
    def wrong(_: Sequence[float], __: TrafficParameters) -> MetricRoadmap:
        raise InvalidInput("lane 'a' is too short")

    simulation = Simulation(CELLS, 5)
    occupancy = coordinator_of(simulation).occupancy
    occupancy.use_map(wrong)
    occupancy.use_zones([ZONE])
    robot = simulation.put(1.0, 6.0)
    robot.head_for(6.0, 6.0, 0.0)
    simulation.run(10.0)
    assert robot.pose[:2] == (1.0, 6.0)
    assert robot.refused and robot.refused[0] == "lane 'a' is too short"
