"""Command guard: a commanded robot stands before it touches anything."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.base import Velocity, VelocityLimits
from ppaas.controllers.command_guard import CommandGuard
from ppaas.controllers.drive_parameters import body_of
from ppaas.controllers.motion import advance
from ppaas.cost_values import LETHAL_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo

RESOLUTION, CELLS, RADIUS, REACTION = 0.05, 80, 0.2, 0.3
LIMITS = VelocityLimits(max_vel_x=0.5, acc_lim_x=1.0, acc_lim_theta=2.0)
CENTRE = Pose2D(2.0, 2.0, 0.0)
GUARD = CommandGuard(body_of((), RADIUS), LIMITS, REACTION)


def costmap_with(*cells: tuple[int, int]) -> Costmap:
    data = np.zeros((CELLS, CELLS), np.uint8)
    for row, column in cells:
        data[row, column] = LETHAL_OBSTACLE
    return Costmap(data, GridInfo(RESOLUTION, CELLS, CELLS))


WALL = costmap_with(*((row, 52) for row in range(CELLS)))
"""A wall 0.62 m ahead of the centre."""


def test_free_space_changes_nothing() -> None:
    assert GUARD.allowed(Velocity(0.5, 0.8), CENTRE, costmap_with()) == Velocity(0.5, 0.8)
    assert GUARD.allowed(Velocity(), CENTRE, WALL) == Velocity()


def test_a_robot_is_slowed_before_a_wall_and_stops_at_it() -> None:
    speeds = [GUARD.allowed(Velocity(0.5, 0.0), Pose2D(x, 2.0, 0.0), WALL).linear for x in (2.0, 2.2, 2.3, 2.4)]
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[0] == 0.5
    assert 0.0 < speeds[1] < 0.5
    assert speeds[-1] == 0.0


def test_a_robot_at_a_wall_may_turn_and_back_away() -> None:
    near = Pose2D(2.41, 2.0, 0.0)
    assert GUARD.allowed(Velocity(0.5, 0.0), near, WALL) == Velocity()
    assert GUARD.allowed(Velocity(0.5, 0.6), near, WALL) == Velocity(0.0, 0.6)
    assert GUARD.allowed(Velocity(-0.4, 0.0), near, WALL) == Velocity(-0.4, 0.0)


def test_a_robot_that_touches_something_may_leave_it() -> None:
    touching = Pose2D(2.5, 2.0, 0.0)
    assert GUARD.allowed(Velocity(0.3, 0.0), touching, WALL) == Velocity()
    assert GUARD.allowed(Velocity(-0.3, 0.0), touching, WALL) == Velocity(-0.3, 0.0)


def test_an_oblong_robot_does_not_turn_its_corner_into_a_wall() -> None:
    footprint = ((0.5, 0.15), (-0.3, 0.15), (-0.3, -0.15), (0.5, -0.15))
    guard = CommandGuard(body_of(footprint, 0.53), LIMITS, REACTION)
    beside = Pose2D(2.35, 2.0, 0.5 * math.pi)
    assert guard.allowed(Velocity(0.0, -1.0), beside, WALL).angular > -1.0
    assert guard.allowed(Velocity(0.0, 0.5), beside, WALL) == Velocity(0.0, 0.5)
    assert guard.allowed(Velocity(0.3, 0.0), beside, WALL) == Velocity(0.3, 0.0)


@given(
    st.lists(st.tuples(st.integers(0, CELLS - 1), st.integers(0, CELLS - 1)), max_size=30),
    st.floats(-0.5, 0.5), st.floats(-1.0, 1.0), st.floats(-math.pi, math.pi),
)  # fmt: skip
def test_no_command_leads_into_a_lethal_cell(
    cells: list[tuple[int, int]], linear: float, angular: float, heading: float
) -> None:
    pose = Pose2D(2.0, 2.0, heading)
    centres = RESOLUTION * (np.array(cells, np.float64).reshape(-1, 2)[:, ::-1] + 0.5)

    def clearance(at: Pose2D) -> float:
        return float(np.hypot(*(centres - (at.x, at.y)).T).min(initial=math.inf))

    allowed = GUARD.allowed(Velocity(linear, angular), pose, costmap_with(*cells))
    assert abs(allowed.linear) <= abs(linear) and abs(allowed.angular) <= abs(angular)
    nearest = min(clearance(advance(pose, allowed, step * REACTION / 10)) for step in range(11))
    assert nearest >= min(RADIUS, clearance(pose)) - 1e-3
