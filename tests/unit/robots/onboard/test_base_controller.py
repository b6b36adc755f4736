import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.clock import ManualClock
from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.onboard.base_controller import STOP, BaseController, BaseLimits


def twist(linear: float, angular: float) -> Twist:
    return Twist(Vector3(x=linear), Vector3(z=angular))


def test_the_last_command_applies_until_it_expires() -> None:
    clock = ManualClock(100.0)
    base = BaseController(BaseLimits(timeout=0.5), clock)
    assert base.velocity() == STOP
    base.command(twist(0.1, 0.2))
    base.command(twist(0.3, -0.4))
    clock.advance(0.5)
    assert base.velocity() == Velocity(0.3, -0.4)
    clock.advance(0.01)
    assert base.velocity() == STOP


@given(st.floats(allow_nan=False, allow_infinity=False), st.floats(allow_nan=False, allow_infinity=False))
def test_commands_are_clamped_to_the_limits(linear: float, angular: float) -> None:
    limits = BaseLimits(max_linear=0.65, max_angular=3.0)
    base = BaseController(limits, ManualClock())
    base.command(twist(linear, angular))
    velocity = base.velocity()
    assert abs(velocity.linear) <= limits.max_linear
    assert abs(velocity.angular) <= limits.max_angular
    assert velocity.linear == linear or abs(linear) > limits.max_linear
    assert velocity.angular == angular or abs(angular) > limits.max_angular


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_not_finite_is_refused_and_stops_the_base(bad: float) -> None:
    base = BaseController(clock=ManualClock())
    for command in (twist(bad, 0.0), twist(0.0, bad)):
        base.command(twist(0.2, 0.0))
        with pytest.raises(InvalidInput, match="finite"):
            base.command(command)
        assert base.velocity() == STOP


@pytest.mark.parametrize("values", [{"timeout": 0.0}, {"max_linear": -1.0}, {"max_angular": math.nan}])
def test_limits_must_be_positive(values: dict[str, float]) -> None:
    with pytest.raises(InvalidParameter, match=next(iter(values))):
        BaseLimits(**values)
