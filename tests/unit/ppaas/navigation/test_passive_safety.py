"""Passive safety: the robot stands before an approaching person reaches it."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.base import Velocity
from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.geometry import Pose2D
from ppaas.navigation.passive_safety import MARGIN, REACTION, PassiveSafety

RADIUS, PERSON, ACCELERATION = 0.18, 0.25, 1.0
HERE, AHEAD = Pose2D(2.0, 1.0, math.pi / 2), Velocity(0.6, 0.3)
PASSIVE_SAFETY = PassiveSafety(RADIUS, ACCELERATION)


def person(x: float, y: float, vx: float, vy: float) -> MovingObstacle:
    return MovingObstacle(x, y, vx, vy, PERSON)


def nearest(gap: float, walking_speed: float, speed: float) -> float:
    """Return the distance of a person who walks straight towards a robot at the time when the robot stands."""
    dt, seconds = 0.001, 0.0
    while speed > 0.0:
        gap -= (speed + walking_speed) * dt
        seconds += dt
        speed -= ACCELERATION * dt if seconds > REACTION else 0.0
    return gap


@given(gap=st.floats(0.0, 4.0), walking_speed=st.floats(0.05, 1.6), wanted=st.floats(0.01, 1.0))
def test_robot_stops_before_an_approaching_person_arrives(gap: float, walking_speed: float, wanted: float) -> None:
    approaching = person(HERE.x, HERE.y + RADIUS + PERSON + gap, 0.0, -walking_speed)
    speed = PASSIVE_SAFETY.slowed(Velocity(wanted, 0.0), HERE, [approaching]).linear
    assert 0.0 <= speed <= wanted
    if speed > 0.0:
        assert nearest(gap, walking_speed, speed) >= MARGIN - 0.005
    if speed < wanted:
        assert nearest(gap, walking_speed, speed + 0.02) <= MARGIN + 0.005, "the speed is not lower than necessary"


def test_slowed_robot_keeps_its_arc_and_heeds_the_nearest_person() -> None:
    far, near = person(2.0, 2.5, 0.0, -1.0), person(2.3, 2.1, -0.4, -1.0)
    slowed = PASSIVE_SAFETY.slowed(AHEAD, HERE, [far, near])
    assert slowed == PASSIVE_SAFETY.slowed(AHEAD, HERE, [near])
    assert 0.0 < slowed.linear < PASSIVE_SAFETY.slowed(AHEAD, HERE, [far]).linear < AHEAD.linear
    assert slowed.angular / slowed.linear == pytest.approx(AHEAD.angular / AHEAD.linear)


def test_robot_stops_for_a_person_close_ahead() -> None:
    assert PASSIVE_SAFETY.slowed(AHEAD, HERE, [person(2.0, 1.5, 0.0, -1.0)]) == Velocity(0.0, 0.0)


@pytest.mark.parametrize(
    ("velocity", "mover"),
    [
        (AHEAD, person(2.0, 1.6, 0.0, 0.5)),  # moves away
        (AHEAD, person(2.0, 0.4, 0.0, 1.0)),  # approaches from behind
        (Velocity(-0.2, 0.0), person(2.0, 1.6, 0.0, -1.0)),  # the robot drives away
        (Velocity(0.0, 1.0), person(2.0, 1.6, 0.0, -1.0)),  # a robot that turns in place comes no nearer
        (AHEAD, person(2.0, 9.0, 0.0, -1.0)),  # far away
    ],
)
def test_other_people_do_not_slow_the_robot(velocity: Velocity, mover: MovingObstacle) -> None:
    assert PASSIVE_SAFETY.slowed(velocity, HERE, [mover]) == velocity
    assert PASSIVE_SAFETY.slowed(velocity, HERE, []) == velocity


def test_reversing_robot_heeds_people_behind_it() -> None:
    behind = person(2.0, 0.2, 0.0, 0.6)
    slowed = PASSIVE_SAFETY.slowed(Velocity(-0.4, 0.0), HERE, [behind])
    assert -0.4 < slowed.linear <= 0.0
