"""Faults in simulated traffic: clocks, false claims, sizes, maps and networks that are not as they should be."""

from collections.abc import Sequence

import numpy as np
import pytest

from benchmarks.fleet.stand_ins.simulation import SPACING, Simulation, roadmap_of
from ppaas.errors import InvalidInput
from ppaas.fleet.lattice_roadmap import LatticeRoadmap
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.roadmap import Roadmap
from ppaas.geometry import Pose2D
from ppaas.traffic.coordinator import TrafficCoordinator
from ppaas.traffic.settings import TrafficParameters

AISLES = "\n".join(["." * 12, *["..###.###..."] * 2, "." * 12] * 3)
OTHER_AISLES = "\n".join(["." * 12, *["..###.......", ".........##."], "." * 12] * 3)


def fleet(robots: int, seed: int, **options: float) -> Simulation:
    """Return robots in a hall with aisles of one lane, which always get new goals."""
    simulation = Simulation(roadmap_of(AISLES), seed, **options)
    for cell in simulation.rng.sample(simulation.cells, robots):
        simulation.add(cell)
    return simulation


def coordinator_of(simulation: Simulation) -> TrafficCoordinator:
    """Return the coordinator of a simulation whose node runs."""
    assert simulation.coordinator is not None
    return simulation.coordinator


def all_get_home(simulation: Simulation) -> None:
    """Run until all robots have reached their goals."""
    simulation.run(240.0, until_home=True)
    assert not [robot.name for robot in simulation.robots if robot.goal_id or robot.refused]


def test_clocks_of_robots_that_differ_change_nothing() -> None:
    one, other = fleet(8, 1), fleet(8, 1)
    for number, robot in enumerate(other.robots):
        robot.clock = 0.5 * (-1.0) ** number
    for simulation in (one, other):
        simulation.run(60.0, again=True)
    assert [robot.pose for robot in one.robots] == [robot.pose for robot in other.robots]


@pytest.mark.parametrize("change", [-3600.0, -1.0, 3600.0])
def test_a_clock_that_is_set_holds_nobody_up_for_long(change: float) -> None:
    simulation = fleet(6, 5, delay=0.2)
    simulation.run(20.0, again=True)
    simulation.robots[0].clock = change
    simulation.run(60.0, again=True)
    coordinator = coordinator_of(simulation)
    assert {member.standing for member in coordinator.members.values()} == {"joined"}
    all_get_home(simulation)
    assert simulation.contacts.count == 0


def test_the_next_node_knows_how_long_goals_have_been_open() -> None:
    simulation = fleet(4, 6)
    simulation.run(30.0, again=True)
    simulation.kill_node()
    simulation.run(2.0)
    simulation.start_node()
    simulation.run(3.0)
    for member in coordinator_of(simulation).members.values():
        if member.report.goal_id:
            assert simulation.now - member.goal_since == pytest.approx(member.report.goal_seconds, abs=1.0)


@pytest.mark.parametrize("seed", [2, 3])
def test_all_get_home_with_messages_that_are_two_seconds_late_and_lost(seed: int) -> None:
    simulation = fleet(8, seed, delay=2.0, loss=0.1)
    simulation.run(120.0, again=True)
    all_get_home(simulation)
    assert min(robot.arrived for robot in simulation.robots) >= 1
    assert simulation.contacts.count == 0


@pytest.mark.parametrize("epoch", [0, None])
def test_a_robot_that_claims_a_cell_of_another_takes_it_from_nobody(epoch: int | None) -> None:
    simulation = fleet(6, 4)
    simulation.run(20.0, again=True)
    coordinator = coordinator_of(simulation)
    robbed = next(robot for robot in simulation.robots[1:] if robot.way.ahead)
    cells = {coordinator.occupancy.cells.closest(point.x, point.y) for point in robbed.way.held}
    claim = simulation.robots[0].report(simulation.now + 0.01)
    claim.epoch = claim.epoch if epoch is None else epoch
    claim.way, claim.ahead = [*claim.way, *robbed.way.held], claim.ahead + len(robbed.way.held)
    coordinator.report(claim, simulation.now)
    assert coordinator.members[robbed.name].held >= cells
    for _ in range(3):
        coordinator.step(simulation.now)
        others = [member for name, member in coordinator.members.items() if name not in {"tb0", robbed.name}]
        assert not cells.intersection(*(member.held for member in others))
    simulation.run(60.0, again=True)
    all_get_home(simulation)
    assert simulation.contacts.count == 0


def test_another_map_under_a_fleet_that_drives_ends_no_goal() -> None:
    simulation = fleet(8, 5)
    simulation.run(30.0, again=True)
    rows = OTHER_AISLES.split("\n")
    other = LatticeRoadmap(Roadmap.of_grid(np.array([[c != "#" for c in row] for row in rows])), SPACING, 0.2, -0.15)
    coordinator_of(simulation).occupancy.use_map(lambda *_: other)
    assert all(robot.goal_id for robot in simulation.robots)
    all_get_home(simulation)
    assert simulation.contacts.count == 0


# -- sizes -------------------------------------------------------------------------------------------------------------


def narrow(radii: Sequence[float], _: TrafficParameters) -> MetricRoadmap:
    """Return a hall whose aisles have room for robots of a radius of 0.2 m alone."""
    radius = max(radii)
    if radius > 0.6:
        raise InvalidInput(f"a robot of radius {radius:g} m fits nowhere on the map")
    return roadmap_of(AISLES if radius <= 0.2 else "\n".join(["#" * 12] * 11 + ["." * 12]))


def in_narrow_hall(*cells: int) -> Simulation:
    """Return robots of 0.2 m in cells of the narrow hall."""
    simulation = Simulation(roadmap_of(AISLES), 6)
    simulation.coordinator = TrafficCoordinator(narrow, TrafficParameters())
    for cell in cells:
        simulation.add(cell)
    return simulation


@pytest.mark.parametrize("radius", [0.5, 0.9])
def test_a_robot_that_is_too_large_for_the_aisles_is_told_so_and_the_others_go_on(radius: float) -> None:
    simulation = in_narrow_hall(0, 11, 14, 20)
    simulation.run(10.0, again=True)
    revisions = [robot.way.revision for robot in simulation.robots]
    large = simulation.put(*simulation.hall.centre(len(simulation.cells) - 6), goal=0, radius=radius)
    others, before = simulation.robots[:-1], simulation.arrived
    simulation.run(90.0, again=True)
    text = "the robot is too large for the aisles in which others drive"
    assert large.refused and all(each.startswith(text) for each in large.refused)
    assert large.arrived == 0 and not large.way.held
    assert simulation.arrived - before >= 8
    assert sum(robot.way.revision for robot in others) <= sum(revisions) + 8, "the others were not stopped"
    assert simulation.contacts.count == 0


def test_what_a_robot_touches_that_is_too_large_is_granted_to_nobody() -> None:
    simulation = in_narrow_hall(0, 11)
    simulation.run(5.0)
    large = simulation.put(*simulation.hall.centre(5), radius=0.5)
    touched = set(simulation.hall.touched(large.pose.x, large.pose.y, large.radius).tolist())
    for robot, goal in zip(simulation.robots[:2], (11, 0), strict=True):
        robot.head_for(*simulation.hall.centre(goal), simulation.now)
    for _ in range(900):
        simulation.step()
        for robot in simulation.robots[:2]:
            assert not touched & coordinator_of(simulation).members[robot.name].held or simulation.now < 6.0
    assert [robot.arrived for robot in simulation.robots] == [1, 1, 0]
    assert simulation.contacts.count == 0


def test_a_robot_that_fits_nowhere_and_comes_first_does_not_keep_others_from_driving() -> None:
    simulation = in_narrow_hall()
    large = simulation.put(*simulation.hall.centre(len(simulation.cells) - 6), goal=0, radius=0.9)
    simulation.run(2.0)
    assert large.way.free, "it is alone"
    robot, other = simulation.add(0, goal=11), simulation.add(14, goal=3)
    simulation.run(90.0, until_home=True)
    assert large.refused and not large.way.free
    assert (robot.arrived, other.arrived) == (1, 1)
    assert simulation.contacts.count == 0


def test_a_robot_that_is_larger_and_fits_leads_to_larger_cells() -> None:
    simulation = in_narrow_hall()
    for cell in (-1, -12):
        simulation.add(simulation.cells[cell])
    simulation.run(5.0)
    simulation.add(simulation.cells[-6], radius=0.25)
    simulation.run(10.0)
    assert coordinator_of(simulation).occupancy.cells is not simulation.hall
    assert len(coordinator_of(simulation).occupancy.cells.roadmap) == 12


# -- robots that follow no grants --------------------------------------------------------------------------------------


def way_round() -> Simulation:
    """Return a robot in the middle of a ring, and another that is led past it, in a hall with two ways."""
    simulation = Simulation(roadmap_of(".....\n.###.\n....."), 3)
    simulation.add(2)
    simulation.add(0, goal=4)
    return simulation


@pytest.mark.parametrize("why", ["by_hand", "held"])
def test_others_are_led_around_a_robot_that_is_aside_and_it_goes_on_to_its_goal_afterwards(why: str) -> None:
    simulation = way_round()
    aside, other = simulation.robots
    aside.head_for(*simulation.hall.centre(5), simulation.now)
    simulation.run(1.5)
    aside.set_aside(why)
    simulation.run(14.0)
    assert other.arrived == 1, "it does not wait until patience has run out"
    member = coordinator_of(simulation).members[aside.name]
    assert (member.standing, member.chain) == (why, [])
    assert coordinator_of(simulation).occupancy.cells.closest(*aside.pose[:2]) in member.base
    assert aside.goal_id and aside.arrived == 0
    aside.set_aside("")
    simulation.run(30.0, until_home=True)
    assert aside.arrived == 1
    assert simulation.contacts.count == 0


def test_what_a_robot_that_is_driven_by_hand_holds_follows_its_place_and_is_granted_to_nobody() -> None:
    simulation = way_round()
    aside, other = simulation.robots
    simulation.run(0.5)
    aside.set_aside("by_hand")
    held = set[int]()
    for step in range(400):
        x, y, theta = aside.pose
        aside.pose = Pose2D(max(x - 0.02, 0.7) if step > 20 else x, y, theta)  # towards the other
        simulation.step()
        member, near = (coordinator_of(simulation).members[robot.name] for robot in simulation.robots)
        held |= member.base
        if step % 10 == 9:
            assert coordinator_of(simulation).occupancy.cells.closest(*aside.pose[:2]) in member.base
            assert not member.base & set(near.chain[1:]), "what is ahead of it was asked back"
    assert held >= {1, 2}
    assert other.arrived == 1, "it was led around the robot"
    assert simulation.contacts.count == 0


def test_a_robot_that_is_alone_and_driven_by_hand_gets_no_grants_and_drives_freely_afterwards() -> None:
    simulation = Simulation(roadmap_of("....."), 3)
    robot = simulation.add(0, goal=4)
    simulation.run(1.5)
    assert robot.way.free
    robot.set_aside("by_hand")
    revision = robot.way.revision
    simulation.run(3.0)
    assert robot.way.revision == revision and not robot.way.free
    robot.set_aside("")
    simulation.run(20.0, until_home=True)
    assert robot.arrived == 1


def test_a_robot_that_is_aside_for_an_unknown_reason_is_refused() -> None:
    simulation = fleet(1, 1)
    simulation.run(2.0)
    report = simulation.robots[0].report(simulation.now + 0.1)
    report.aside = "asleep"
    with pytest.raises(InvalidInput, match="asleep"):
        coordinator_of(simulation).report(report, simulation.now)


# -- poses -------------------------------------------------------------------------------------------------------------


def test_robots_that_stand_close_to_each_other_come_no_closer_since_poses_are_not_exact() -> None:
    simulation = Simulation(roadmap_of("......\n......"), 7)
    simulation.put(0.0, 0.22, goal=5)
    simulation.run(0.5)
    simulation.put(0.41, 0.0, goal=4).dead = True
    simulation.step()
    gap = simulation.contacts.nearest
    assert 0.0 < gap < 0.1
    simulation.run(30.0)
    assert simulation.contacts.nearest == pytest.approx(gap, abs=1e-3)
    simulation.robots[1].dead = False
    simulation.run(60.0, until_home=True)
    assert simulation.arrived == 2
    assert simulation.contacts.nearest == pytest.approx(gap, abs=1e-3)
