"""Robots of simulated traffic that dock and undock on straight ways of their own, among others that drive."""

import math

import pytest

from benchmarks.fleet.stand_ins.robot import StandIn
from benchmarks.fleet.stand_ins.simulation import Simulation, roadmap_of
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.fleet.traffic import MapPoint
from ppaas.traffic.coordinator import state_of

HALL = "\n".join(["." * 9] * 5)
FAR = 0.7
"""Length of an approach [m]."""


class Docks:
    """A hall in which robots dock by driving up from a cell."""

    def __init__(self, seed: int = 1, **options: float) -> None:
        self.simulation = Simulation(roadmap_of(HALL), seed, **options)
        self.hall = self.simulation.hall

    def robot(self, column: int, row: int) -> StandIn:
        """Add a robot."""
        return self.simulation.add(9 * row + column)

    def place(self, robot: StandIn) -> tuple[MapPoint, MapPoint]:
        """Return the approach of a robot from where it stands."""
        x, y, _ = robot.pose
        return MapPoint(x, y), MapPoint(x, y + FAR)

    def dock(self, robot: StandIn, seconds: float = 60.0, *, ways: tuple[MapPoint, MapPoint] | None = None) -> float:
        """Drive a robot on its approach once it may; return the time that it waited [s]."""
        approach = ways or self.place(robot)
        robot.set_aside("held", *approach)
        return self.follow(robot, approach, seconds)

    def follow(self, robot: StandIn, approach: tuple[MapPoint, MapPoint], seconds: float = 60.0) -> float:
        """Drive on an approach that was reported."""
        begin, waited = self.simulation.now, math.nan
        while self.simulation.now - begin < seconds:
            self.simulation.step()
            if not robot.may_approach:
                continue
            waited = self.simulation.now - begin if math.isnan(waited) else waited
            self.step_to(robot, approach[1])
            if (robot.pose.x, robot.pose.y) == (approach[1].x, approach[1].y):
                return waited
        raise AssertionError("it does not get there")

    @staticmethod
    def step_to(robot: StandIn, place: MapPoint) -> None:
        """Drive nearer to a place for a cycle."""
        dx, dy = place.x - robot.pose.x, place.y - robot.pose.y
        part = min(0.015 / max(math.hypot(dx, dy), 1e-9), 1.0)
        robot.pose = Pose2D(robot.pose.x + part * dx, robot.pose.y + part * dy, robot.pose.theta)
        if part == 1.0:
            robot.pose = Pose2D(place.x, place.y, robot.pose.theta)

    def stay(self, robot: StandIn) -> None:
        """Report that it is docked."""
        robot.set_aside("held", MapPoint(robot.pose.x, robot.pose.y))

    def state(self, robot: StandIn) -> str:
        """Return its state in the traffic."""
        coordinator = self.simulation.coordinator
        assert coordinator is not None
        shown = state_of(coordinator, 0.0, self.simulation.now, 0.0).robots
        return next(each.state for each in shown if each.robot == robot.name)

    def send(self, robot: StandIn, column: int, row: int) -> None:
        """Give a robot a goal."""
        robot.head_for(*self.hall.centre(9 * row + column), self.simulation.now)


@pytest.mark.parametrize("seed", range(4))
def test_others_keep_out_of_an_approach_until_the_robot_has_undocked(seed: int) -> None:
    docks = Docks(seed, delay=0.2)
    docking = docks.robot(4, 1)
    others = [docks.robot(0, 2), docks.robot(8, 2), docks.robot(0, 3), docks.robot(8, 3)]
    docks.simulation.run(2.0)
    for robot, column in zip(others, (8, 0, 8, 0), strict=True):
        docks.send(robot, column, 2 + (robot in others[2:]))
    docks.simulation.run(2.0)
    start = docking.pose
    docks.dock(docking)
    docks.stay(docking)
    docks.simulation.run(3.0)
    assert docks.state(docking) == "docked"
    docks.simulation.run(60.0, until_home=True)
    assert all(robot.arrived == 1 for robot in others), "they are led around it"
    out = MapPoint(docking.pose.x, docking.pose.y), MapPoint(start.x, start.y)
    for robot, column in zip(others, (0, 8, 0, 8), strict=True):
        docks.send(robot, column, 2 + (robot in others[2:]))
    docks.dock(docking, ways=out)
    docking.set_aside("")
    docks.send(docking, 6, 0)
    docks.simulation.run(60.0, until_home=True)
    assert docking.arrived == 1 and all(robot.arrived == 2 for robot in others)
    assert docks.simulation.contacts.count == 0


def test_a_robot_waits_until_another_has_left_its_approach() -> None:
    docks = Docks()
    docking, other = docks.robot(4, 1), docks.robot(4, 2)
    docks.simulation.run(3.0)
    docking.set_aside("held", *(approach := docks.place(docking)))
    docks.simulation.run(4.0)
    assert not docking.may_approach and docks.state(docking) == "docking"
    assert docking.way.grants is not None and docking.way.grants.waits_for == other.name
    docks.send(other, 8, 2)
    assert docks.follow(docking, approach) > 0.3
    assert docks.simulation.contacts.count == 0


def test_of_two_whose_approaches_cross_the_first_one_goes_first() -> None:
    docks = Docks()
    first, second = docks.robot(4, 1), docks.robot(2, 2)
    docks.simulation.run(3.0)
    one = docks.place(first)
    x, y, _ = second.pose
    other = MapPoint(x, y), MapPoint(x + 1.2, y)  # to where the first one docks
    first.set_aside("held", *one)
    docks.simulation.run(0.3)
    second.set_aside("held", *other)
    docks.simulation.run(2.0)
    assert first.may_approach and not second.may_approach
    docks.follow(first, one)
    docks.stay(first)
    docks.simulation.run(3.0)
    assert not second.may_approach, "the first one stands there"
    docks.dock(first, ways=(one[1], one[0]))
    first.set_aside("")
    docks.simulation.run(2.0)
    assert second.may_approach
    assert docks.simulation.contacts.count == 0


def test_a_robot_that_is_alone_may_dock_at_once() -> None:
    docks = Docks()
    docking = docks.robot(4, 1)
    docks.simulation.run(3.0)
    assert docking.way.free
    assert docks.dock(docking) < 1.0


def test_the_next_node_grants_an_approach_that_was_begun() -> None:
    docks = Docks()
    docking, _ = docks.robot(4, 1), docks.robot(0, 3)
    docks.simulation.run(3.0)
    docking.set_aside("held", *docks.place(docking))
    docks.simulation.run(1.0)
    assert docking.may_approach
    docks.simulation.kill_node()
    docks.simulation.run(1.0)
    docks.simulation.start_node()
    docks.simulation.run(4.0)
    assert docking.may_approach and docking.way.epoch > 0


def test_approaches_that_are_none_are_refused() -> None:
    docks = Docks()
    docking = docks.robot(4, 1)
    docks.simulation.run(2.0)
    coordinator = docks.simulation.coordinator
    assert coordinator is not None
    begin, _ = docks.place(docking)
    for aside, approach in (("", [begin]), ("held", [begin] * 3), ("held", [begin, MapPoint(90.0, 0.0)])):
        docking.aside, docking.approach = aside, approach
        with pytest.raises(InvalidInput, match="approach"):
            coordinator.report(docking.report(docks.simulation.now + 0.1), docks.simulation.now)
