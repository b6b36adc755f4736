"""The robot's clock."""

from ppaas.clock import ManualClock
from robots.bridges.core.parts import RobotTime


def test_stamps_count_on_from_those_of_the_robot() -> None:
    clock = ManualClock(10.0)
    time = RobotTime(clock, lambda: 1000.5)
    assert time.now() == {"sec": 1000, "nanosec": 500_000_000}, "the robot's clock is unknown"
    time.heard({"sec": 0, "nanosec": 0}, 10.0)
    assert time.now()["sec"] == 1000, "a stamp of zero says nothing"
    time.heard({"sec": 50, "nanosec": 250_000_000}, 10.0)
    clock.advance(2.5)
    assert time.now() == {"sec": 52, "nanosec": 750_000_000}
