import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.base import Velocity
from ppaas.controllers.dwa import DwaParameters
from ppaas.controllers.motion import advance, brake, turn
from ppaas.geometry import Pose2D

LIMITS = DwaParameters()
velocities = st.builds(Velocity, st.floats(0.0, 0.5), st.floats(-1.5, 1.5))


@given(velocities, st.floats(-3.0, 3.0))
def test_advance_is_the_limit_of_small_straight_steps(velocity, theta):
    x, y, heading = 0.0, 0.0, theta
    for _ in range(2_000):
        x += velocity.linear * math.cos(heading) / 2_000
        y += velocity.linear * math.sin(heading) / 2_000
        heading += velocity.angular / 2_000
    there = advance(Pose2D(0.0, 0.0, theta), velocity, 1.0)
    assert (there.x, there.y) == pytest.approx((x, y), abs=1e-3)
    assert math.cos(there.theta - heading) == pytest.approx(1.0)


@given(velocities)
def test_braking_keeps_the_limits_and_ends_at_rest(velocity):
    cycles = 0
    while velocity != Velocity(0.0, 0.0):
        slower = brake(velocity, LIMITS, 0.1)
        assert 0.0 <= velocity.linear - slower.linear <= 0.1 + 1e-9
        assert abs(velocity.angular - slower.angular) <= 0.3 + 1e-9
        velocity = slower
        cycles += 1
        assert cycles < 20


def test_braking_keeps_the_arc_within_the_turning_limit():
    assert brake(Velocity(0.4, 0.8), LIMITS, 0.1) == pytest.approx((0.3, 0.6))
    assert brake(Velocity(-0.4, 0.8), LIMITS, 0.1) == pytest.approx((-0.3, 0.6))
    assert brake(Velocity(0.1, 1.5), LIMITS, 0.1) == pytest.approx((0.0, 1.2))


@given(st.floats(-3.1, 3.1).filter(lambda error: abs(error) > 0.1), st.floats(0.02, 0.2))
def test_turning_in_place_does_not_overshoot(error, period):
    turning, past, at_once = Velocity(), 0.0, error
    for _ in range(500):
        turning = turn(at_once, turning, LIMITS, period)
        assert LIMITS.min_vel_theta - 1e-9 <= abs(turning.angular) <= LIMITS.max_vel_theta
        at_once -= turning.angular * period
        past = min(past, math.copysign(1.0, error) * at_once)
        if abs(at_once) < 0.075:
            break
    assert abs(at_once) < 0.075
    assert past > -0.1


def test_driving_robot_brakes_before_it_turns():
    assert turn(1.0, Velocity(0.5, 0.2), LIMITS, 0.1) == brake(Velocity(0.5, 0.2), LIMITS, 0.1)
