"""Traffic in simulated time: nobody touches anybody, all get home, and faults change neither."""

from collections.abc import Sequence
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.fleet.stand_ins.simulation import Simulation, roadmap_of
from benchmarks.fleet.stand_ins.strips import CASES, ReportedCase
from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.traffic import coordinator
from ppaas.traffic.coordinator import TrafficCoordinator, checkpoint_of
from ppaas.traffic.members import PERSON, ROBOT, Kind
from ppaas.traffic.settings import TrafficParameters
from tests.support.budget import examples

AISLES = "\n".join(["." * 12, *["..###.###..."] * 2, "." * 12] * 3)


def fleet(robots: int, seed: int, **options: float) -> Simulation:
    """Return robots in a hall with aisles of one lane, which always get new goals."""
    simulation = Simulation(roadmap_of(AISLES), seed, **options)
    for cell in simulation.rng.sample(simulation.cells, robots):
        simulation.add(cell)
    return simulation


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_all_are_home_in_the_cases_that_others_reported(case: ReportedCase) -> None:
    simulation = case.simulation(1)
    simulation.run(90.0, until_home=True)
    assert simulation.arrived == case.goals
    assert simulation.nearest > 0.0


@settings(max_examples=examples(8))
@given(st.integers(2, 12), st.integers(0, 1000), st.floats(0.0, 1.0), st.floats(0.0, 0.3), st.floats(0.0, 0.05))
def test_nobody_touches_anybody_with_late_and_lost_messages(
    robots: int, seed: int, delay: float, loss: float, stalls: float
) -> None:
    simulation = fleet(robots, seed, delay=delay, loss=loss, stalls=stalls)
    simulation.run(60.0, again=True)
    assert simulation.nearest > 0.0


def test_all_of_a_fleet_reach_goals_and_nobody_waits_for_ever() -> None:
    simulation = fleet(8, 3)
    simulation.run(240.0, again=True)
    assert min(robot.arrived for robot in simulation.robots) >= 3
    assert simulation.stood < 5.0
    assert simulation.nearest > 0.0


def test_a_plan_that_many_are_behind_is_made_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    halls = roadmap_of("\n".join(["." * 24, *["..###.###.###.###.###..."] * 2] * 6 + ["." * 24]))

    def goals() -> int:
        simulation = Simulation(halls, 0)
        for cell in simulation.rng.sample(simulation.cells, 40):
            simulation.add(cell)
        simulation.run(300.0, again=True)
        assert simulation.nearest > 0.0
        return simulation.arrived

    crowd = goals()
    monkeypatch.setattr(coordinator, "STALE", 2.0)
    assert crowd > 1.2 * goals(), "more goals are reached than by one plan"


def test_robots_that_stop_for_ever_are_planned_around() -> None:
    simulation = fleet(8, 4)
    simulation.run(30.0, again=True)
    simulation.robots[0].dead = True
    simulation.run(60.0, again=True)
    before = simulation.arrived
    simulation.run(120.0, again=True)
    assert simulation.coordinator is not None
    assert simulation.coordinator.members["tb0"].standing in {"stopped", "joined"}
    assert simulation.arrived - before >= 8
    assert simulation.nearest > 0.0


def test_the_next_node_grants_again_within_two_seconds_and_takes_nothing_back() -> None:
    simulation = fleet(8, 5)
    simulation.run(40.0, again=True)
    simulation.kill_node()
    simulation.run(10.0, again=True)
    held = [len(robot.way.held) for robot in simulation.robots]
    simulation.start_node()
    simulation.run(2.0, again=True)
    assert any(robot.way.ahead for robot in simulation.robots)
    before = simulation.arrived
    simulation.run(60.0, again=True)
    assert simulation.arrived > before
    assert simulation.nearest > 0.0
    assert max(held) <= 3, "robots drive to the ends of their grants and stand"


def test_a_node_that_is_outranked_takes_a_higher_epoch() -> None:
    simulation = fleet(4, 6)
    simulation.run(10.0, again=True)
    old = simulation.coordinator
    assert old is not None
    simulation.start_node(old.epoch)
    simulation.run(10.0, again=True)
    assert simulation.coordinator is not None and simulation.coordinator.epoch > old.epoch
    assert simulation.nearest > 0.0


def test_a_robot_that_comes_stops_those_that_were_granted_where_it_stands() -> None:
    simulation = fleet(3, 7)
    simulation.run(20.0, again=True)
    driving = next(robot for robot in simulation.robots if robot.way.ahead == 2)
    end = driving.way.held[-1]
    simulation.put(end.x, end.y)
    simulation.run(60.0, again=True)
    assert simulation.nearest > 0.0


def test_a_robot_between_cells_is_led_to_one() -> None:
    hall = roadmap_of("....\n....")
    simulation = Simulation(hall, 8)
    simulation.put(0.3, 0.3, goal=3)
    simulation.add(7, goal=4)
    simulation.run(60.0, until_home=True)
    assert simulation.arrived == 2


def test_a_stray_is_led_back() -> None:
    simulation = fleet(3, 9)
    simulation.run(20.0, again=True)
    robot = simulation.robots[0]
    robot.pose = robot.pose._replace(x=robot.pose.x + 0.28, y=robot.pose.y + 0.1)
    before = robot.arrived
    simulation.run(60.0, again=True)
    assert robot.arrived > before


def test_a_goal_that_nobody_can_reach_is_refused() -> None:
    hall = roadmap_of("...#.")
    simulation = Simulation(hall, 10)
    first, _ = simulation.add(0, goal=3), simulation.add(2)
    simulation.run(10.0)
    assert first.refused == ["there is no way to it for the robots of the traffic"]


def test_a_goal_on_which_a_broken_robot_stands_is_refused_in_the_end() -> None:
    hall = roadmap_of("......")
    simulation = Simulation(hall, 11, parameters=TrafficParameters(patience=3.0, retry=1.0))
    simulation.add(5, goal=0)
    broken = simulation.add(2, goal=5)
    broken.dead = True
    simulation.run(5.0)
    simulation.robots[0].head_for(*hall.centre(2), simulation.now)
    simulation.run(60.0)
    assert simulation.robots[0].refused == ["robot tb1 stands on it and does not move"]


def test_a_robot_that_is_alone_drives_freely_until_another_comes() -> None:
    hall = roadmap_of("......\n......")
    simulation = Simulation(hall, 12)
    robot = simulation.add(0, goal=5)
    simulation.run(3.0)
    assert robot.way.free
    simulation.add(11, goal=6)
    simulation.run(3.0)
    assert not robot.way.free
    simulation.run(60.0, until_home=True)
    assert simulation.arrived == 2
    assert simulation.nearest > 0.0


def test_a_robot_that_is_taken_out_holds_nothing_and_takes_part_again_when_it_is_put_back() -> None:
    simulation = fleet(3, 13)
    simulation.run(10.0, again=True)
    assert simulation.coordinator is not None
    occupancy = simulation.coordinator.occupancy
    occupancy.take_out("tb0")
    assert not occupancy.members["tb0"].held
    simulation.run(5.0)
    assert simulation.robots[0].way.free
    occupancy.put_back("tb0")
    simulation.run(5.0)
    assert occupancy.members["tb0"].held and not simulation.robots[0].way.free


def test_what_silent_robots_held_by_a_checkpoint_is_held() -> None:
    simulation = fleet(4, 14)
    simulation.run(20.0, again=True)
    coordinator = simulation.coordinator
    assert coordinator is not None
    state = checkpoint_of(coordinator)
    held = coordinator.members["tb0"].held
    simulation.robots[0].silent = True
    coordinator = simulation.start_node(state=state)
    simulation.run(6.0, again=True)
    assert coordinator.members["tb0"].held >= held
    assert simulation.nearest > 0.0


def test_what_a_robot_may_hold_by_a_checkpoint_is_not_granted_to_it() -> None:
    simulation = fleet(4, 14)
    simulation.run(20.0, again=True)
    assert simulation.coordinator is not None
    state = checkpoint_of(simulation.coordinator)
    coordinator = simulation.start_node(state=state)
    sent = [grants for k in range(30) for grants in coordinator.step(simulation.now + 0.1 * k)]
    assert {grants.robot for grants in sent} == {"tb0", "tb1", "tb2", "tb3"}
    assert not any(grants.way or grants.spur or grants.at_goal for grants in sent)
    for robot in simulation.robots:
        coordinator.report(robot.report(simulation.now + 3.0), simulation.now + 3.0)
    sent = coordinator.step(simulation.now + 3.0)
    assert all(grants.way for grants in sent) and len(sent) == 4


def test_a_report_replaces_what_a_robot_may_hold_by_a_checkpoint_before_the_next_epoch_begins() -> None:
    simulation = fleet(4, 14)
    simulation.run(20.0, again=True)
    assert simulation.coordinator is not None
    state = checkpoint_of(simulation.coordinator)
    coordinator = simulation.start_node(state=state)
    for robot in simulation.robots:
        coordinator.report(robot.report(simulation.now + 0.1), simulation.now + 0.1)
    cells = coordinator.occupancy.cells
    for robot in simulation.robots:
        held = [cells.closest(point.x, point.y) for point in robot.way.held]
        assert coordinator.members[robot.name].chain == held


@pytest.mark.parametrize("silent", [False, True])
def test_a_robot_that_was_taken_out_stays_out_with_the_next_node(silent: bool) -> None:
    simulation = fleet(4, 14)
    simulation.run(20.0, again=True)
    assert simulation.coordinator is not None
    simulation.coordinator.occupancy.take_out("tb0")
    state = checkpoint_of(simulation.coordinator)
    simulation.robots[0].silent = silent  # it does not learn of it, and reports what it held
    coordinator = simulation.start_node(state=state)
    simulation.run(0.5)
    simulation.robots[0].silent = False
    simulation.run(6.0, again=True)
    member = coordinator.members["tb0"]
    assert (member.standing, member.held, member.report.free) == ("out", set(), True)


def test_a_larger_robot_needs_larger_cells() -> None:
    asked: list[tuple[float, ...]] = []

    def make(radii: Sequence[float], _: TrafficParameters) -> object:
        asked.append(tuple(radii))
        return roadmap_of("....\n....")

    simulation = fleet(1, 15)
    simulation.coordinator = TrafficCoordinator(make, TrafficParameters())  # type: ignore[arg-type]
    simulation.run(3.0)
    simulation.put(1.2, 0.6, radius=0.25)
    simulation.run(3.0)
    assert asked == [(0.2,), (0.2, 0.25)]


def test_another_map_begins_all_ways_anew() -> None:
    simulation = fleet(4, 16)
    simulation.run(20.0, again=True)
    before = [robot.way.revision for robot in simulation.robots]
    assert simulation.coordinator is not None
    simulation.coordinator.occupancy.use_map(lambda *_: simulation.hall)
    simulation.run(20.0, again=True)
    assert all(robot.way.revision > old for robot, old in zip(simulation.robots, before, strict=True))
    assert simulation.nearest > 0.0


def test_cells_in_which_something_is_found_are_planned_around() -> None:
    hall = roadmap_of("......\n......")
    simulation = Simulation(hall, 17)
    robot = simulation.add(0, goal=5)
    simulation.add(11)
    simulation.run(3.0)
    assert simulation.coordinator is not None
    report = robot.report(simulation.now + 0.01)
    report.blocked.extend(robot.way.held[-1:])
    simulation.coordinator.report(report, simulation.now)
    blocked = hall.closest(report.blocked[0].x, report.blocked[0].y)
    simulation.run(3.0)
    assert blocked not in simulation.coordinator.members["tb0"].held
    simulation.run(60.0, until_home=True)
    assert robot.arrived == 1


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("x", np.inf),
        ("radius", -1.0),
        ("radius", 99.0),
        ("speed", 0.0),
        ("ahead", 7),
        ("revision", -1),
        ("braking", 1e9),
    ],
)
def test_a_report_that_is_not_valid_is_refused(field: str, value: float) -> None:
    simulation = fleet(2, 18)
    simulation.run(2.0)
    coordinator = simulation.coordinator
    assert coordinator is not None
    report = simulation.robots[0].report(simulation.now)
    setattr(report, field, value)
    before = coordinator.members["tb0"].report
    with pytest.raises(Exception, match="robot 'tb0'"):
        coordinator.report(report, simulation.now)
    assert coordinator.members["tb0"].report is before


def test_the_same_seed_gives_the_same_traffic() -> None:
    one, other = fleet(6, 19), fleet(6, 19)
    for simulation in (one, other):
        simulation.rng = Random(1)
        simulation.run(30.0, again=True)
    assert [robot.pose for robot in one.robots] == [robot.pose for robot in other.robots]


def test_two_robots_that_stand_close_together_part_without_asking_each_other_for_ever() -> None:
    simulation = Simulation(roadmap_of("....\n...."), 20)
    simulation.put(0.55, 0.3, goal=0)
    simulation.put(1.05, 0.3, goal=3)
    simulation.run(60.0, until_home=True)
    assert simulation.arrived == 2
    assert max(robot.way.revision for robot in simulation.robots) <= 3
    assert simulation.nearest > 0.0


@pytest.mark.parametrize("kind", [ROBOT, PERSON])
def test_nobody_is_granted_a_cell_in_which_an_outsider_is_and_one_that_stays_is_planned_around(kind: Kind) -> None:
    hall = roadmap_of("......\n......")
    simulation = Simulation(hall, 21, parameters=TrafficParameters(patience=5.0))
    simulation.add(0, goal=5)
    simulation.add(11)
    outsider = MovingObstacle(*hall.centre(2), 0.0, 0.0, 0.25)
    coordinator = simulation.coordinator
    assert coordinator is not None
    for _ in range(100):
        seen = [outsider, MovingObstacle(*hall.centre(11), 0.0, 0.0, 0.25)] if kind == ROBOT else [outsider]
        coordinator.occupancy.see_others(kind, seen, simulation.now)
        simulation.step()
        member = coordinator.members.get("tb0")
        assert member is None or 2 not in member.held
    assert coordinator.members["tb0"].waits_for in {kind, ""}
    for _ in range(300):
        coordinator.occupancy.see_others(kind, [outsider], simulation.now)
        simulation.step()
    assert simulation.robots[0].arrived == 1
    assert coordinator.members["tb0"].waits_for == ""


def test_a_robot_that_was_forgotten_and_comes_back_takes_its_first_grants() -> None:
    hall = roadmap_of("......\n......")
    simulation = Simulation(hall, 22, parameters=TrafficParameters(forget=20.0))
    robot = simulation.add(0)
    simulation.add(11)
    simulation.run(30.0)
    robot.silent = True
    simulation.run(25.0)
    assert simulation.coordinator is not None and "tb0" not in simulation.coordinator.members
    robot.silent, known = False, robot.way.number
    simulation.run(1.0)
    assert robot.way.number > known
