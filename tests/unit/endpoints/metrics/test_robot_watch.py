"""Robots as their containers report them: who waits, since when, and who is stopped."""

import pytest

from endpoints.metrics.robot_watch import RobotWatch
from engine.protocols.robot_link import ContainerBeat, StopsInForce
from engine.specs.robot_report import StateReport
from ppaas.clock import ManualClock
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.health.stops import RobotStop
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.still_place import StillRobot

STOP = RobotStop("robot", "tb1", "ann", 1.0, "a pallet fell")


class Hall:
    """A cloud with robot tb1, what is read of it, and the clock of the readings."""

    def __init__(self) -> None:
        self.cloud, self.clock, self.place = FakeCloud(), ManualClock(50.0), StillRobot()
        self.cloud.running = [container("c1", connected=True), container("c2", kind="planning", robot=None)]
        self.cloud.connect("ann", "tb1", self.place)
        self.watch = RobotWatch(self.cloud.containers, self.cloud.place, self.clock)

    def report(self, text: str, goal: Status = Status.ACTIVE) -> None:
        self.place.take(ContainerBeat(busy=True, robot=True, report=StateReport(goal=goal, goal_text=text)))

    async def longest(self) -> float:
        return (await self.watch.read())[1]


@pytest.fixture
def hall() -> Hall:
    return Hall()


async def test_only_robots_are_read(hall: Hall) -> None:
    [robot] = (await hall.watch.read())[0]
    assert (robot.user, robot.robot, robot.connected, robot.waits, robot.report) == (
        "ann", "tb1", True, False, StateReport()
    )  # fmt: skip


async def test_a_wait_lasts_from_the_first_reading_until_one_without_it(hall: Hall) -> None:
    hall.report("waiting: tb2 goes first")
    hall.clock.advance(100.0)
    assert await hall.longest() == 0.0, "it may have begun just now"
    hall.clock.advance(15.0)
    hall.report("waiting: tb3 goes first")
    assert await hall.longest() == 15.0
    hall.report("")
    assert await hall.longest() == 0.0
    hall.report("waiting: tb2 goes first")
    hall.clock.advance(15.0)
    assert await hall.longest() == 0.0


@pytest.mark.parametrize(("goal", "text"), [(Status.ABORTED, "waiting: too long"), (Status.ACTIVE, "planning")])
async def test_a_robot_that_does_something_else_does_not_wait(hall: Hall, goal: Status, text: str) -> None:
    hall.report(text, goal)
    assert not (await hall.watch.read())[0][0].waits


async def test_a_stopped_robot_is_stopped_and_waits_for_nothing(hall: Hall) -> None:
    hall.report("waiting: stopped by 'ann'")
    hall.place.take(StopsInForce((STOP,), ()))
    [robot] = (await hall.watch.read())[0]
    assert (robot.stopped, robot.waits) == (True, False)


async def test_a_robot_whose_place_has_just_closed_is_listed_without_a_report(hall: Hall) -> None:
    hall.cloud.places.clear()
    [robot] = (await hall.watch.read())[0]
    assert (robot.report, robot.stopped) == (StateReport(), False)
