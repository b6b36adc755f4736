"""Cars of lifts in simulated traffic: nobody gives way into a car, and robots that ride stay in it."""

from benchmarks.fleet.stand_ins.simulation import SPACING, Simulation, roadmap_of
from ppaas.fleet.cell_rules import rules_on
from ppaas.traffic.members import Member
from ppaas.traffic.plan_ahead import PlanAhead
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone

LOBBY = """
##..##
##..##
......
#...##
"""
"""A lobby, with a car of four cells on one side, and a bay on the other."""


LEFT, RIGHT, TOP, BOTTOM = (edge * SPACING for edge in (1.5, 3.5, -0.5, 1.4))
RING = [[LEFT, TOP], [RIGHT, TOP], [RIGHT, BOTTOM], [LEFT, BOTTOM], [LEFT, TOP]]
LIFT = [
    Zone(Polygon([RING]), LiftCar(name="car", lift="A")),
    Zone(LineString([[LEFT, BOTTOM], [RIGHT, BOTTOM]]), Door(name="landing", lift="A")),
]
RADIUS = 0.2


def with_car(seed: int) -> Simulation:
    simulation = Simulation(roadmap_of(LOBBY), seed)
    assert simulation.coordinator is not None
    simulation.coordinator.occupancy.use_zones(LIFT)
    return simulation


def cell(simulation: Simulation, row: int, column: int) -> int:
    return int(simulation.hall.roadmap.numbers[row, column])


def moves(plan: PlanAhead, member: Member, at: int) -> list[int]:
    """Return the cells that a robot may enter from one."""
    found: list[int] = plan._plan.roadmap_of(plan._index[member.name]).neighbours[at].tolist()
    return found


def is_in_car(y: float) -> bool:
    return y < 1.5 * SPACING


def test_robots_that_wait_before_a_lift_give_way_elsewhere() -> None:
    for seed in range(2):
        simulation = with_car(seed)
        waits = [simulation.add(cell(simulation, 2, column)) for column in (2, 3)]
        passes = simulation.add(cell(simulation, 2, 5), cell(simulation, 2, 0))
        for _ in range(400):
            simulation.step()
            assert not any(is_in_car(robot.pose.y) for robot in (*waits, passes))
        assert (passes.arrived, simulation.contacts.count) == (1, 0)


def test_robots_enter_and_leave_a_car_for_goals_and_otherwise_stay_in_it() -> None:
    simulation = with_car(1)
    rides = simulation.add(cell(simulation, 0, 2))
    boards = simulation.add(cell(simulation, 2, 0), cell(simulation, 0, 3))
    waits = simulation.add(cell(simulation, 2, 3))
    for _ in range(300):
        simulation.step()
        assert is_in_car(rides.pose.y) and not is_in_car(waits.pose.y)
    assert boards.arrived == 1 and is_in_car(boards.pose.y)
    rides.head_for(*simulation.hall.centre(cell(simulation, 2, 5)), simulation.now)
    simulation.run(40.0)
    assert rides.arrived == 1 and is_in_car(boards.pose.y) and not is_in_car(waits.pose.y)
    assert simulation.contacts.count == 0


def test_a_robot_that_has_left_a_car_does_not_give_way_back_into_it() -> None:
    simulation = with_car(1)
    hall = simulation.hall
    rules = rules_on(hall, LIFT, RADIUS)
    robot = simulation.add(cell(simulation, 1, 2), cell(simulation, 2, 5))
    member = Member(robot.report(0.0), 0.0, chain=[cell(simulation, 1, 2)])
    plan = PlanAhead(rules, {member.name: member.chain[-1]}, {member.name: member}, 0, {member.name: 0})
    member.aim = robot.goal_id
    assert plan.aim(member, cell(simulation, 2, 5), 0.0)
    inside, outside = cell(simulation, 1, 2), cell(simulation, 2, 2)
    assert outside in moves(plan, member, inside)
    while plan.end_of(member) in rules.cars[0]:
        assert plan.extend()
        member.queue.clear()
    assert inside not in moves(plan, member, outside)
