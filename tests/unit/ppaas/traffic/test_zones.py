"""Zones of a map in simulated traffic: robots obey them, touch nobody, and still all get to their goals."""

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.fleet.stand_ins.robot import StandIn
from benchmarks.fleet.stand_ins.simulation import SPACING, Simulation, roadmap_of
from ppaas.geometry import Pose2D
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Capacity, KeepOut, NoStop, OneWay, Rule, Zone
from tests.support.budget import examples

RING = "......\n.####.\n......"
CROSSING = "###.###\n###.###\n.......\n###.###\n###.###"
ROOM = """
......######
.####.......
......######
"""


def box(rule: Rule, top: float, left: float, bottom: float, right: float) -> Zone:
    """Return a zone over whole cells, from a row and column to others."""
    low_x, low_y, high_x, high_y = [(each - half) * SPACING for each, half in
                                    ((left, 0.4), (top, 0.4), (right, -0.4), (bottom, -0.4))]  # fmt: skip
    ring = [[low_x, low_y], [high_x, low_y], [high_x, high_y], [low_x, high_y], [low_x, low_y]]
    return Zone(Polygon([ring]), rule)  # type: ignore[arg-type]


def simulation_of(text: str, *zones: Zone, seed: int = 1, **options: float) -> Simulation:
    simulation = Simulation(roadmap_of(text), seed, **options)
    assert simulation.coordinator is not None
    simulation.coordinator.occupancy.use_zones(zones)
    return simulation


def number(simulation: Simulation, row: int, column: int) -> int:
    return int(simulation.hall.roadmap.numbers[row, column])


def run(simulation: Simulation, seconds: float, check: Callable[[StandIn], None], *, again: bool = True) -> None:
    """Run for a time [s], and check each robot after each cycle."""
    for _ in range(round(seconds / 0.1)):
        simulation.step(again=again)
        for robot in simulation.robots:
            check(robot)
    assert simulation.nearest > 0.0


def inside(simulation: Simulation, zone: Zone) -> list[StandIn]:
    """Return the robots of which a part is in a zone."""
    places = np.array([(robot.pose.x, robot.pose.y) for robot in simulation.robots])
    apart = zone.area.distances(places).tolist()
    return [each for each, distance in zip(simulation.robots, apart, strict=True) if distance < each.radius]


@pytest.mark.parametrize("robots", [1, 3])
def test_robots_drive_one_way_around_a_ring(robots: int) -> None:
    lane = LineString([[0.0, 0.0], [5 * SPACING, 0.0]])
    simulation = simulation_of(RING, Zone(lane, OneWay(name="north", width=0.5)))
    for cell in simulation.rng.sample(simulation.cells, robots):
        simulation.add(cell)
    before: dict[str, float] = {}

    def check(robot: StandIn) -> None:
        x, y = robot.pose.x, robot.pose.y
        if abs(y) < 0.1 and 0.5 * SPACING < x < 4.5 * SPACING and robot.name in before:
            assert x >= before[robot.name] - 0.01, "it drives against the lane"
        before[robot.name] = x

    run(simulation, 200.0, check)
    assert min(robot.arrived for robot in simulation.robots) >= 4


def test_a_lane_from_which_no_way_leads_back_makes_goals_unreachable_and_says_so() -> None:
    simulation = simulation_of("......", box(OneWay(name="east", direction=0.0), 0, 0, 0, 5))
    robot, other = simulation.add(number(simulation, 0, 5), 0), simulation.add(number(simulation, 0, 2))
    run(simulation, 10.0, lambda _: None, again=False)
    assert (robot.arrived, other.arrived) == (0, 0)
    assert robot.refused and "zones of the map close it" in robot.refused[0]


@pytest.mark.parametrize("robots", [1, 2])
def test_no_more_robots_than_fit_are_in_a_zone_at_a_time(robots: int) -> None:
    zone = box(Capacity(name="dock", robots=robots), 1, 7, 1, 11)
    simulation = simulation_of(ROOM.strip(), zone)
    for column in range(5):
        simulation.add(number(simulation, 0, column))
    run(simulation, 300.0, lambda _: _assert_few(simulation, zone, robots))
    assert min(robot.arrived for robot in simulation.robots) >= 3
    assert simulation.stood < 6.0


def _assert_few(simulation: Simulation, zone: Zone, robots: int) -> None:
    assert len(inside(simulation, zone)) <= robots


def test_nobody_stands_in_a_crossing_in_which_robots_do_not_stop() -> None:
    zone = box(NoStop(name="crossing"), 2, 3, 2, 3)
    simulation = simulation_of(CROSSING, zone)
    ends = [(2, 0), (2, 6), (0, 3), (4, 3)]
    for start, goal in zip(ends, [(2, 6), (2, 0), (4, 3), (0, 3)], strict=True):
        simulation.add(number(simulation, *start), number(simulation, *goal))
    stood: dict[str, float] = {}
    before: dict[str, Pose2D] = {}

    def check(robot: StandIn) -> None:
        stands = robot in inside(simulation, zone) and robot.pose == before.get(robot.name)
        before[robot.name] = robot.pose
        stood[robot.name] = stood.get(robot.name, 0.0) + 0.1 if stands else 0.0
        assert stood[robot.name] < 2.0, "longer than it takes to turn"

    run(simulation, 90.0, check, again=False)
    assert [robot.arrived for robot in simulation.robots] == [1, 1, 1, 1]


def test_goals_in_a_zone_in_which_robots_do_not_stop_are_refused_and_idle_robots_leave_it() -> None:
    zone = box(NoStop(name="crossing"), 2, 2, 2, 4)
    simulation = simulation_of(CROSSING, zone)
    idle, other = simulation.add(number(simulation, 2, 3)), simulation.add(number(simulation, 0, 3))
    other.head_for(*simulation.hall.centre(number(simulation, 2, 4)), 0.0)
    run(simulation, 30.0, lambda _: None, again=False)
    assert idle not in inside(simulation, zone)
    assert other.refused and "do not stop" in other.refused[0]


def test_robots_leave_a_zone_that_is_closed_and_do_not_come_back_until_it_opens() -> None:
    zone = box(KeepOut(name="east"), 0, 6, 2, 11)
    simulation = simulation_of("............\n............\n............")
    for column in (2, 8, 10):
        simulation.add(number(simulation, 1, column))
    run(simulation, 30.0, lambda _: None)
    assert simulation.coordinator is not None
    simulation.coordinator.occupancy.use_zones([zone])
    for robot in simulation.robots:
        robot.head_for(*simulation.hall.centre(0), simulation.now)
    run(simulation, 60.0, lambda _: None, again=False)
    assert inside(simulation, zone) == []
    simulation.coordinator.occupancy.use_zones([])
    arrived = simulation.arrived
    run(simulation, 60.0, lambda _: None)
    assert simulation.arrived > arrived + 2


def test_zones_that_change_while_robots_drive_take_nothing_back() -> None:
    simulation = simulation_of(ROOM.strip())
    for column in range(5):
        simulation.add(number(simulation, 0, column))
    sets: list[list[Zone]] = [
        [box(Capacity(name="dock", robots=1), 1, 7, 1, 11)],
        [box(NoStop(name="door"), 1, 5, 1, 6)],
        [box(OneWay(name="south", direction=math.pi / 2), 0, 0, 2, 0)],
        [],
    ]
    ways: dict[str, tuple[int, int]] = {}

    def check(robot: StandIn) -> None:
        now = robot.report(simulation.now)
        revision, end = ways.get(robot.name, (-1, 0))
        assert now.revision != revision or now.first + len(now.way) >= end, "a grant was taken back"
        ways[robot.name] = now.revision, now.first + len(now.way)

    for zones in itertools.islice(itertools.cycle(sets), 12):
        assert simulation.coordinator is not None
        simulation.coordinator.occupancy.use_zones(zones)
        run(simulation, 15.0, check)
    assert min(robot.arrived for robot in simulation.robots) >= 2


@settings(max_examples=examples(15))
@given(st.data(), st.integers(2, 6), st.integers(0, 1000), st.floats(0.0, 0.5), st.floats(0.0, 0.2))
def test_nobody_touches_anybody_and_goals_are_reached_whatever_the_zones(
    data: st.DataObject, robots: int, seed: int, delay: float, loss: float
) -> None:
    rules: list[Rule] = [NoStop(name="a"), Capacity(name="b", robots=1), Capacity(name="c", robots=2)]
    zones = []
    for rule in rules:
        top, left = data.draw(st.integers(0, 6)), data.draw(st.integers(0, 9))
        zones.append(box(rule, top, left, top + data.draw(st.integers(0, 2)), left + data.draw(st.integers(0, 3))))
    text = "\n".join(["." * 12, *["..###.###..."] * 2] * 2 + ["." * 12])
    simulation = simulation_of(text, *zones, seed=seed, delay=delay, loss=loss)
    for cell in simulation.rng.sample(simulation.cells, robots):
        simulation.add(cell)
    simulation.run(150.0, again=True)
    assert simulation.nearest > 0.0
    assert simulation.arrived >= 2
    assert simulation.stood < 20.0
