import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.pure_pursuit.parameters import PurePursuitParameters
from ppaas.controllers.pure_pursuit.regulation import regulated_speed
from ppaas.cost_values import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION

P = PurePursuitParameters(max_vel_x=0.5, max_vel_theta=9.0, acc_lim_x=9.0, robot_radius=0.2)
FAR = 10.0


def test_speed_on_a_straight_free_path_is_the_maximum():
    assert regulated_speed(P, 0.0, FREE_SPACE, FAR) == 0.5
    assert regulated_speed(P, 0.0, NO_INFORMATION, FAR) == 0.5


@pytest.mark.parametrize(("radius", "speed"), [(1.8, 0.5), (0.9, 0.5), (0.72, 0.4), (0.45, 0.25), (0.09, 0.25)])
def test_speed_in_a_curve_is_proportional_to_its_radius(radius, speed):
    for side in (1.0, -1.0):
        assert regulated_speed(P, side / radius, FREE_SPACE, FAR) == pytest.approx(speed)
    free = PurePursuitParameters(max_vel_theta=9.0, acc_lim_x=9.0, use_regulated_linear_velocity_scaling=False)
    assert regulated_speed(free, 1.0 / radius, FREE_SPACE, FAR) == 0.5


@pytest.mark.parametrize(("distance", "speed"), [(0.7, 0.5), (0.5, 0.5 * 0.5 / 0.6), (0.35, 0.5 * 0.35 / 0.6)])
def test_speed_near_an_obstacle_is_proportional_to_its_distance(distance, speed):
    cost = 252.0 * math.exp(-10.0 * (distance - 0.2))
    assert regulated_speed(P, 0.0, max(1, round(cost)), FAR) == pytest.approx(speed, rel=0.03)


def test_cost_regulation_keeps_the_minimum_speed():
    assert regulated_speed(P, 0.0, INSCRIBED_INFLATED_OBSTACLE, FAR) == 0.25
    blind = PurePursuitParameters(acc_lim_x=9.0, use_cost_regulated_linear_velocity_scaling=False)
    assert regulated_speed(blind, 0.0, INSCRIBED_INFLATED_OBSTACLE, FAR) == 0.5


@pytest.mark.parametrize(("to_go", "speed"), [(0.6, 0.5), (0.3, 0.25), (0.12, 0.1), (0.01, 0.05), (0.0, 0.05)])
def test_speed_near_the_goal_is_reduced_to_the_approach_minimum(to_go, speed):
    assert regulated_speed(P, 0.0, FREE_SPACE, to_go) == pytest.approx(speed)


@given(
    curvature=st.floats(-20.0, 20.0), cost=st.integers(0, 255), to_go=st.floats(0.0, 5.0),
    braking=st.floats(0.1, 3.0), turning=st.floats(0.3, 3.0),
)  # fmt: skip
def test_speed_never_exceeds_turning_braking_or_maximum_limits(curvature, cost, to_go, braking, turning):
    p = PurePursuitParameters(acc_lim_x=braking, max_vel_theta=turning)
    speed = regulated_speed(p, curvature, cost, to_go)
    assert 0.0 < speed <= p.max_vel_x
    assert speed * abs(curvature) <= turning * (1.0 + 1e-9)
    assert speed**2 <= max(braking * to_go, p.min_approach_linear_velocity**2) * (1.0 + 1e-9)
