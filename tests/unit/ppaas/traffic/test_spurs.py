"""Spurs: robots reach goals beside the centres of cells, hold what they touch there, and drive back for others."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.fleet.stand_ins.robot import TOLERANCE, StandIn
from benchmarks.fleet.stand_ins.simulation import SPACING, Simulation, roadmap_of
from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.errors import InvalidInput
from ppaas.messages.fleet.traffic import MapPoint
from ppaas.traffic.coordinator import checkpoint_of
from ppaas.traffic.granted_way import REACHED, GrantedWay
from ppaas.traffic.members import PERSON, Member, check_report
from ppaas.traffic.plan_ahead import SETTLES, Spurs
from ppaas.zones.shapes import Polygon
from ppaas.zones.zone import NoStop, Zone
from tests.support.budget import examples

AISLES = "\n".join(["." * 12, *["..###.###..."] * 2, "." * 12] * 3)
ROOM = "\n".join(["......"] * 4)


def member_of(simulation: Simulation, robot: StandIn) -> Member:
    """Return what the coordinator knows of a robot."""
    assert simulation.coordinator is not None
    return simulation.coordinator.members[robot.name]


def two(cell: int, other: int, text: str = ROOM) -> tuple[Simulation, StandIn, StandIn]:
    """Return two robots in a hall, since one alone drives freely."""
    simulation = Simulation(roadmap_of(text), 1)
    return simulation, simulation.add(cell), simulation.add(other)


def on_its_spur() -> tuple[Simulation, StandIn, StandIn]:
    """Return a robot that has reached a goal by a spur into the cell 14, and another one."""
    simulation, robot, other = two(0, 23)
    robot.head_for(2 * SPACING, 1.45 * SPACING, 0.0)
    simulation.run(30.0, until_home=True)
    return simulation, robot, other


def test_a_goal_at_the_corner_of_four_cells_is_reached_and_all_of_them_are_held() -> None:
    simulation, robot, _ = two(0, 23)
    robot.head_for(1.5 * SPACING, 1.5 * SPACING, 0.0)
    simulation.run(30.0, until_home=True)
    simulation.run(1.0)
    assert robot.misses == [pytest.approx(0.0, abs=TOLERANCE)]
    assert member_of(simulation, robot).held == {7, 8, 13, 14}


def test_a_goal_within_the_tolerance_takes_no_other_cell() -> None:
    simulation, robot, _ = two(0, 23)
    robot.head_for(2 * SPACING + 0.14, SPACING, 0.0)
    simulation.run(30.0, until_home=True)
    assert member_of(simulation, robot).held == {8}
    assert robot.misses[0] <= TOLERANCE + 0.05


def test_it_drives_back_to_the_centre_before_it_goes_on() -> None:
    simulation, robot, _ = two(0, 23)
    robot.head_for(2.4 * SPACING, SPACING, 0.0)
    simulation.run(30.0, until_home=True)
    robot.head_for(0.0, SPACING, simulation.now)
    nearest = math.inf
    while robot.goal is not None and simulation.now < 60.0:
        simulation.step()
        nearest = min(nearest, math.dist(robot.pose[:2], (2 * SPACING, SPACING)))
        assert robot.pose.x < 2.5 * SPACING
    assert robot.goal is None and nearest <= REACHED
    assert member_of(simulation, robot).spur is None


def test_one_goal_after_the_other_in_one_cell() -> None:
    simulation, robot, _ = two(0, 23)
    for x, y in [(1.4, 1.4), (0.6, 1.4), (1.0, 1.0), (1.4, 0.6)]:
        robot.head_for(x * SPACING, y * SPACING, simulation.now)
        simulation.run(20.0, until_home=True)
    assert len(robot.misses) == 4 and max(robot.misses) <= TOLERANCE


def test_one_that_stands_on_its_spur_drives_back_when_it_is_waited_for() -> None:
    simulation, robot, other = on_its_spur()
    simulation.run(30.0)
    assert 14 in member_of(simulation, robot).held, "nobody waits, so it stays"
    other.head_for(2 * SPACING, 2 * SPACING, simulation.now)
    simulation.run(30.0, until_home=True)
    assert other.misses == [pytest.approx(0.0, abs=TOLERANCE)]
    assert 14 not in member_of(simulation, robot).held
    assert simulation.nearest > 0.0


def test_it_settles_in_its_cell_if_the_one_beside_is_not_left() -> None:
    simulation, robot, other = two(0, 23)
    other.head_for(2 * SPACING, 2 * SPACING, 0.0)
    simulation.run(30.0, until_home=True)
    other.dead = True
    robot.head_for(2 * SPACING, 1.45 * SPACING, simulation.now)
    began = simulation.now
    simulation.run(60.0, until_home=True)
    assert 0.15 < robot.misses[0] < 0.45 * SPACING
    assert SETTLES < simulation.now - began < 30.0
    assert simulation.nearest > 0.05


def test_one_that_cannot_drive_back_from_its_spur_becomes_an_obstacle() -> None:
    simulation, robot, other = on_its_spur()
    robot.dead = True
    other.head_for(2 * SPACING, 2 * SPACING, simulation.now)
    simulation.run(200.0, until_home=True)
    assert other.refused == ["robot tb0 stands on it and does not move"]
    other.head_for(SPACING, 2 * SPACING, simulation.now)
    simulation.run(30.0, until_home=True)
    assert other.arrived == 1 and simulation.nearest > 0.0


def test_it_waits_for_a_person_beside_its_goal() -> None:
    simulation, robot, _ = two(0, 23)
    robot.head_for(2 * SPACING, 1.45 * SPACING, 0.0)
    assert simulation.coordinator is not None
    while simulation.now < 15.0:
        person = MovingObstacle(2 * SPACING, 2 * SPACING, 0.0, 0.0, 0.2)
        simulation.coordinator.occupancy.see_others(PERSON, [person], simulation.now)
        simulation.step()
        assert not robot.way.spur
    assert robot.arrived == 1 and robot.misses[0] > 0.15


def test_no_spur_leads_to_cells_in_which_robots_do_not_stop() -> None:
    simulation, robot, _ = two(0, 23)
    simulation.run(1.0)
    assert simulation.coordinator is not None
    ring = [[x * SPACING, y * SPACING] for x, y in [(-1.0, 1.6), (7.0, 1.6), (7.0, 2.4), (-1.0, 2.4), (-1.0, 1.6)]]
    simulation.coordinator.occupancy.use_zones([Zone(Polygon([ring]), NoStop(name="aisle"))])  # type: ignore[arg-type]
    robot.head_for(2 * SPACING, 0.6 * SPACING, simulation.now)
    simulation.run(30.0, until_home=True)
    robot.head_for(2 * SPACING, 1.4 * SPACING, simulation.now)
    simulation.run(30.0, until_home=True)
    assert len(robot.misses) == 2
    assert member_of(simulation, robot).held == {8}


@pytest.mark.parametrize("when", [0.3, 1.0, 3.0, 30.0])
def test_the_next_node_knows_who_is_on_a_spur(when: float) -> None:
    simulation, robot, other = two(2, 23)
    robot.head_for(2 * SPACING, 1.45 * SPACING, 0.0)
    while not robot.way.spur:
        simulation.step()
    simulation.run(when)
    simulation.kill_node()
    simulation.run(1.0)
    simulation.start_node()
    simulation.run(2.5)
    assert member_of(simulation, robot).held >= {8, 14}
    other.head_for(2 * SPACING, 2 * SPACING, simulation.now)
    simulation.run(60.0, until_home=True)
    assert (robot.arrived, other.arrived) == (1, 1)
    assert simulation.nearest > 0.0


def test_the_next_node_does_not_take_the_spur_to_an_earlier_goal_for_one_to_the_next_goal() -> None:
    simulation, robot, _ = on_its_spur()
    robot.head_for(2.4 * SPACING, SPACING, simulation.now)
    simulation.start_node()
    assert simulation.coordinator is not None
    simulation.coordinator.report(robot.report(simulation.now), simulation.now)
    member = member_of(simulation, robot)
    assert member.spur is not None and (member.spur.goal_id, member.decided) == ("", "")
    assert member.held >= {8, 14}
    simulation.run(30.0, until_home=True)
    assert len(robot.misses) == 2 and max(robot.misses) <= TOLERANCE


def test_a_stray_on_its_spur_is_led_back() -> None:
    simulation, robot, _ = two(0, 23)
    robot.head_for(2.4 * SPACING, SPACING, 0.0)
    simulation.run(30.0, until_home=True)
    robot.pose = robot.pose._replace(y=robot.pose.y + 0.3)
    robot.head_for(0.0, 0.0, simulation.now)
    simulation.run(60.0, until_home=True)
    assert robot.arrived == 2


@pytest.mark.parametrize("spur", [[MapPoint(0.0, 0.0)] * 2, [MapPoint(9.0, 0.0)], [MapPoint(math.nan, 0.0)]])
def test_a_spur_that_cannot_be_is_refused(spur: list[MapPoint]) -> None:
    simulation, robot, _ = two(0, 23)
    simulation.run(2.0)
    report = robot.report(simulation.now)
    report.spur = spur
    assert simulation.coordinator is not None
    with pytest.raises(InvalidInput, match="robot 'tb0'"):
        simulation.coordinator.report(report, simulation.now)


def test_a_spur_ends_when_the_plan_leads_the_robot_on_before_its_goal_is_reached() -> None:
    simulation, robot, _ = two(0, 23)
    robot.head_for(2 * SPACING, 1.45 * SPACING, 0.0)
    while not robot.way.spur or robot.way.ahead:
        simulation.step()
    simulation.run(0.5)
    assert simulation.coordinator is not None
    member, spurs = member_of(simulation, robot), Spurs(simulation.coordinator.occupancy)
    spurs.end(member, 9, waited_for=True)
    assert member.spur is not None and not member.spur.ended_by
    member.queue.popleft()
    spurs.end(member, 9, waited_for=False)
    assert member.spur.ended_by == 9 and member.decided == ""


FAULTS = st.sampled_from(["node", "clone", "silent", "stall"])


@settings(max_examples=examples(10))
@given(st.integers(2, 7), st.integers(0, 10_000), st.lists(st.tuples(FAULTS, st.integers(1, 150)), max_size=8))
def test_all_get_home_after_faults_of_nodes_clones_and_networks(
    robots: int, seed: int, faults: list[tuple[str, int]]
) -> None:
    simulation = Simulation(roadmap_of(AISLES), seed, 0.3, beside=0.5)
    for cell in simulation.rng.sample(simulation.cells, robots):
        simulation.add(cell)
    for number, (fault, tenths) in enumerate(faults):
        simulation.run(tenths / 10.0, again=True)
        robot = simulation.rng.choice(simulation.robots)
        if fault == "node":
            assert simulation.coordinator is not None
            state = checkpoint_of(simulation.coordinator)
            simulation.run(tenths / 30.0, again=True)
            simulation.start_node(state=state)
        elif fault == "clone":
            robot.way, robot.stray = GrantedWay(robot.radius), False
            robot.way.revision = 1000 * (number + 1)
        elif fault == "silent":
            robot.silent = True
            simulation.run(tenths / 10.0, again=True)
            robot.silent = False
        else:
            robot.stalled_until = simulation.now + tenths / 10.0
    simulation.run(300.0, until_home=True)
    assert not [robot.name for robot in simulation.robots if robot.goal_id]
    assert simulation.nearest > 0.0


@settings(max_examples=examples(12))
@given(
    st.integers(2, 14),
    st.integers(0, 10_000),
    st.floats(0.0, 1.5),
    st.floats(0.0, 0.3),
    st.floats(0.0, 0.05),
    st.booleans(),
)
def test_with_goals_anywhere_nobody_touches_anybody_whatever_is_late_lost_or_killed(
    robots: int, seed: int, delay: float, loss: float, stalls: float, killed: bool
) -> None:
    simulation = Simulation(roadmap_of(AISLES), seed, delay, loss, stalls, beside=0.5)
    for cell in simulation.rng.sample(simulation.cells, robots):
        simulation.add(cell)
    for _ in range(3):
        simulation.run(20.0, again=True)
        if killed:
            simulation.kill_node()
            simulation.run(2.0, again=True)
            simulation.start_node()
    assert simulation.nearest > 0.0


def test_with_goals_anywhere_all_get_home() -> None:
    simulation = Simulation(roadmap_of(AISLES), 3, beside=0.45)
    for cell in simulation.rng.sample(simulation.cells, 10):
        simulation.add(cell)
    simulation.run(180.0, again=True)
    simulation.run(240.0, until_home=True)
    assert not [robot.name for robot in simulation.robots if robot.goal_id or robot.refused]
    assert simulation.stood < 10.0
    assert sorted(simulation.misses)[len(simulation.misses) * 3 // 4] <= TOLERANCE


def test_a_robot_may_report_a_spur_from_which_it_drives_back_to_a_long_way() -> None:
    simulation, robot, _ = on_its_spur()
    report = robot.report(simulation.now)
    [place] = report.spur
    longer = [MapPoint(place.x + 0.5 * cell, place.y) for cell in range(1, 15)]
    report.way, report.ahead = [*report.way, *longer], report.ahead + len(longer)
    check_report(report)
    report.way, report.ahead = longer[-2:], 0
    with pytest.raises(InvalidInput, match="does not begin on its way"):
        check_report(report)


def test_no_spur_leads_to_a_goal_from_the_cell_of_one_that_was_called_off() -> None:
    simulation, robot, _ = two(0, 23)
    simulation.run(2.0)
    goals = [(1.4 * SPACING, 0.0), (4.4 * SPACING, 2.4 * SPACING), (0.4 * SPACING, 2.4 * SPACING)]
    for number in range(150):
        robot.head_for(*goals[number % 3], simulation.now)
        simulation.run(0.1 * (1 + number % 17))
        member = member_of(simulation, robot)
        if member.spur is not None:
            assert math.dist(*member.spur.line) < SPACING
