"""Restarts of a robot, by its odometry."""

import math

import pytest

from robots.bridges.core.localization import SILENCE, TOGETHER, RestartWatch


def odometry(x: float, *, stamp: float = 100.0, yaw: float = 0.0) -> dict[str, object]:
    turn = {"z": math.sin(yaw / 2.0), "w": math.cos(yaw / 2.0)}
    seconds = {"sec": int(stamp), "nanosec": 0}
    return {"header": {"stamp": seconds}, "pose": {"pose": {"position": {"x": x, "y": 0.0}, "orientation": turn}}}


def watch(x: float = 4.0) -> RestartWatch:
    """Return a watch that knows a publisher, and a robot at ``x`` at the time 10."""
    watched = RestartWatch()
    watched.publishers(["a"], 0.0)
    watched.odometry(odometry(x), 10.0)
    return watched


@pytest.mark.parametrize(
    ("before", "message", "passed"),
    [
        (4.0, odometry(0.0), 0.1),
        (4.0, odometry(0.0), 600.0),
        (0.0, odometry(0.0, yaw=2.0 * math.pi), SILENCE + 0.1),
        (4.0, odometry(4.0, stamp=5.0), 0.1),
    ],
    ids=["jump", "origin after long", "never moved", "clock set back"],
)
@pytest.mark.parametrize("late", [False, True])
def test_a_new_publisher_and_odometry_that_begins_anew_are_a_restart(
    before: float, message: dict[str, object], passed: float, *, late: bool
) -> None:
    watched = watch(before)
    now = 10.0 + passed
    if late:  # the graph tells of the publisher after its first message
        watched.odometry(message, now)
        watched.publishers(["b"], now + 0.5)
    else:
        watched.publishers(["a", "b"], now - 0.05)
        watched.odometry(message, now)
    assert watched.restarted()
    assert not watched.restarted(), "one restart is told once"


def test_a_reset_of_the_same_publisher_is_none() -> None:
    watched = watch()
    watched.publishers(["a"], 10.1)
    watched.odometry(odometry(0.0), 10.2)
    assert not watched.restarted()
    watched.publishers(["a", "b"], 10.3 + TOGETHER)
    assert not watched.restarted(), "another publisher much later has nothing to do with it"


def test_a_new_publisher_that_continues_the_odometry_is_none() -> None:
    watched = watch()
    watched.publishers(["b"], 12.0)
    watched.odometry(odometry(4.3, stamp=102.0), 12.1)
    assert not watched.restarted()


def test_a_publisher_that_comes_back_is_no_new_one() -> None:
    watched = watch(0.0)
    watched.publishers([], 11.0)
    watched.publishers(["a"], 15.0)
    watched.odometry(odometry(0.0, stamp=105.0), 15.1)
    assert not watched.restarted(), "the network was gone"
