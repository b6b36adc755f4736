"""Progress checker: detects a base that does not follow commands."""

import itertools
import math

from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D
from ppaas.navigation.progress_checker import FORGOTTEN, HOLD, LEAST, WINDOW, ProgressChecker, ProgressFailure

DT = 0.05


class Base:
    """Executes a part of the command of some cycles ago."""

    def __init__(self, part: float = 1.0, delay: int = 6) -> None:
        self.part = part
        self.odom = Pose2D(0.0, 0.0)
        self.now = 100.0
        self.watch = ProgressChecker()
        self.found: list[ProgressFailure | None] = []
        self._pending = [Velocity()] * delay

    def drive(self, seconds: float, linear: float, angular: float = 0.0) -> None:
        for _ in range(round(seconds / DT)):
            sent = Velocity(linear, angular)
            if self.found and self.found[-1] is not None:
                sent = Velocity()
            self._pending.append(sent)
            done = self._pending.pop(0)
            self.odom = self.odom @ Pose2D(self.part * done.linear * DT, 0.0, self.part * done.angular * DT)
            self.now += DT
            self.found.append(self.watch.look(self.now, sent, self.odom))

    @property
    def failures(self) -> list[ProgressFailure]:
        return [each for each in self.found if each is not None]


def test_base_that_ignores_commands_is_detected_and_held():
    base = Base(part=0.0)
    base.drive(2 * WINDOW, 0.3)
    first = next(number for number, each in enumerate(base.found) if each is not None)
    assert (first + 1) * DT <= WINDOW + 2 * DT
    assert base.failures[0].reason == ("the base does not follow cmd_vel: 0.30 m/s commanded, 0.00 m/s driven")
    assert len(base.failures) * DT <= HOLD


def test_failing_base_is_retried_and_keeps_its_failure_start():
    base = Base(part=0.0)
    base.drive(10.0, 0.3)
    held = [each is not None for each in base.found]
    assert sum(now and not before for before, now in itertools.pairwise(held)) == 2
    assert len({each.since for each in base.failures}) == 1
    assert base.failures[0].since < 100.0 + 2 * DT


def test_later_failure_has_its_own_start():
    base = Base(part=0.0)
    base.drive(2 * WINDOW, 0.3)
    base.part = 1.0
    base.drive(10.0, 0.3)
    assert base.found[-1] is None
    again = base.now
    base.part = 0.0
    base.drive(2 * WINDOW + HOLD, 0.3)
    assert base.failures[-1].since >= again - WINDOW - DT


def test_failure_is_forgotten_after_a_long_time_without_commands():
    base = Base(part=0.0)
    base.drive(2 * WINDOW, 0.3)
    base.drive(FORGOTTEN + 2 * WINDOW, 0.0)
    later = base.now
    base.drive(2 * WINDOW, 0.3)
    assert base.failures[-1].since >= later - WINDOW - DT


def test_base_that_does_not_turn_is_reported_with_turn_rates():
    base = Base(part=0.0)
    base.drive(2 * WINDOW, 0.0, 0.5)
    assert base.failures[0].reason.endswith("0.50 rad/s commanded, 0.00 rad/s driven")


def test_base_that_turns_through_pi_is_not_a_failure():
    base = Base()
    base.drive(30.0, 0.2, 1.5)
    assert not base.failures


def test_odometry_jumps_and_missing_cycles_are_not_failures():
    base = Base()
    base.drive(1.0, 0.3)
    base.odom = Pose2D(-20.0, 3.0, 1.0)
    base.drive(1.0, 0.3)
    base.now += 30.0
    base.drive(10.0, 0.3)
    assert not base.failures


def test_rapidly_alternating_commands_are_not_checked():
    base = Base(part=0.0)
    for number in range(200):
        base.drive(DT, 0.0, math.copysign(0.8, number % 2 - 0.5))
    assert not base.failures


@given(
    st.floats(0.9, 1.5),
    st.integers(0, 6),
    st.lists(st.tuples(st.floats(0.1, 1.0), st.floats(-1.0, 1.0)), max_size=12),
)
def test_base_that_follows_within_0_3_s_is_not_a_failure(part, delay, commands):
    base = Base(part, delay)
    for linear, angular in commands:
        base.drive(WINDOW, linear, angular)
    assert not base.failures


@given(st.floats(0.0, LEAST - 0.05), st.floats(0.1, 1.0))
def test_base_that_follows_too_little_is_detected(part, linear):
    base = Base(part)
    base.drive(WINDOW + 3 * DT, linear)
    assert base.failures
