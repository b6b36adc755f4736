"""Velocities into a dock, and what is in the way."""

import math

import numpy as np
import pytest

from ppaas.controllers.base import Velocity
from ppaas.docking.approach import BodyOutline, DockControl, along_axis, apart_from_dock, is_in_way
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D, wrap_angle

BODY = BodyOutline(0.2, 0.2, 0.2)


def driven(place: Pose2D, to: float, ahead: float, seconds: float = 60.0) -> Pose2D:
    """Drive a unicycle whose heading on the axis is 0 if it drives ahead, and half a turn if it drives backwards."""
    turn = 0.0 if ahead > 0.0 else math.pi
    pose, dt = place @ Pose2D(0.0, 0.0, turn), 0.05
    for _ in range(round(seconds / dt)):
        seen = Pose2D(pose.x, pose.y, wrap_angle(pose.theta - turn))
        if (to - place.x) * (to - seen.x) <= 0.0:
            return seen
        velocity = along_axis(seen, DockControl(), to=to, ahead=ahead)
        pose = pose @ Pose2D(velocity.linear * dt, 0.0, velocity.angular * dt)
    raise AssertionError(f"still at {pose}")


@pytest.mark.parametrize("ahead", [1.0, -1.0])
@pytest.mark.parametrize("place", [(-0.7, 0.0, 0.0), (-0.7, 0.15, 0.3), (-0.7, -0.2, -0.4), (-1.0, 0.3, 1.2)])
def test_a_robot_comes_onto_the_axis_forward_and_backward(place: tuple[float, float, float], ahead: float) -> None:
    end = driven(Pose2D(*place), 0.0, ahead)
    assert abs(end.y) < 0.02
    assert abs(end.theta) < 0.15


@pytest.mark.parametrize("ahead", [1.0, -1.0])
def test_a_robot_backs_off_along_the_axis(ahead: float) -> None:
    end = driven(Pose2D(0.0, 0.02, 0.1), -0.7, ahead)
    assert abs(end.y) < 0.04
    assert abs(end.theta) < 0.1


def test_a_robot_slows_down_at_the_dock() -> None:
    control = DockControl()
    assert along_axis(Pose2D(-1.0, 0.0), control, to=0.0).linear == control.v_linear_max
    assert along_axis(Pose2D(-0.01, 0.0), control, to=0.0).linear == pytest.approx(control.v_linear_min, abs=0.01)


@pytest.mark.parametrize("wrong", [{"v_linear_max": 0.0}, {"k_delta": -1.0}, {"slowdown_radius": math.nan}])
def test_parameters_out_of_range_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(InvalidParameter, match=next(iter(wrong))):
        DockControl(**wrong)


@pytest.mark.parametrize(
    ("point", "linear", "blocked"),
    [
        ((0.3, 0.0), 0.15, True),
        ((0.3, 0.25), 0.15, False),
        ((0.6, 0.0), 0.15, False),
        ((-0.3, 0.0), 0.15, False),
        ((-0.3, 0.1), -0.15, True),
        ((0.3, 0.0), 0.0, False),
    ],
)
def test_what_is_in_the_way_blocks(point: tuple[float, float], linear: float, blocked: bool) -> None:
    assert is_in_way(np.array([point]), BODY, Velocity(linear, 0.0), 1.0) is blocked


def test_what_is_behind_the_face_belongs_to_the_dock() -> None:
    points = np.array([(0.3, 0.0), (0.5, 0.1), (0.62, 0.0), (0.9, 0.4)])
    assert apart_from_dock(points, Pose2D(0.6, 0.0)).tolist() == [[0.3, 0.0], [0.5, 0.1]]
