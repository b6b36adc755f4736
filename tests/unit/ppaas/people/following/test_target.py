"""Person whom a robot follows."""

import math

import pytest

from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import LOST, PREDICTED, SEEN, TrackedPerson
from ppaas.people.following.following import LONGEST_PREDICTION, Target


def person(x: float, y: float = 0.0, vx: float = 0.5, vy: float = 0.0, state: str = SEEN) -> TrackedPerson:
    return TrackedPerson(1, Point(x, y), Point(vx, vy), [0.0] * 4, state=state)


def test_position_is_predicted_from_the_arrival_for_a_limited_time():
    target = Target(0.0)
    target.take(person(1.0), 10.0)
    assert target.position(11.0) == (1.5, 0.0)
    assert target.position(11.0, 1.0) == (2.0, 0.0)
    assert target.position(99.0) == (1.0 + 0.5 * LONGEST_PREDICTION, 0.0)


def test_person_who_stands_is_not_expected_ahead():
    target = Target(0.0)
    target.take(person(1.0, vx=0.05), 10.0)
    assert not target.walking and target.position(10.0, 1.0) == (1.0, 0.0)
    assert target.heading is None


def test_walking_begins_and_ends_at_different_speeds():
    target = Target(0.0)
    walks = []
    for speed in (0.2, 0.35, 0.2, 0.1, 0.2):
        target.take(person(1.0, vx=speed), 1.0)
        walks.append(target.walking)
    assert walks == [False, True, True, False, False]
    assert target.heading == 0.0


def test_lost_or_missing_person_keeps_the_last_position():
    target = Target(0.0)
    target.take(None, 1.0)
    assert not target.known
    target.take(person(1.0), 2.0)
    target.take(person(5.0, state=LOST), 3.0)
    target.take(None, 4.0)
    assert target.known and target.position(2.0) == (1.0, 0.0) and target.seen_at == 2.0


def test_predicted_person_was_last_seen_before():
    target = Target(0.0)
    target.take(person(1.0), 2.0)
    target.take(person(3.0, state=PREDICTED), 6.0)
    assert target.seen_at == 2.0 and target.seen.position.x == 1.0 and target.last.position.x == 3.0


def test_place_behind_is_on_the_path_walked_also_around_a_corner():
    target = Target(0.0)
    for step in range(11):
        target.take(person(0.2 * step), float(step))
    for step in range(1, 6):
        target.take(person(2.0, 0.2 * step, 0.0, 0.5), 10.0 + step)
    assert target.behind(15.0, 0.0, 2.0) == pytest.approx((1.0, 0.0))
    assert target.behind(15.0, 1.0, 1.0) == pytest.approx((2.0, 0.5))
    assert target.behind(15.0, 0.0, 9.0) is None
    assert target.heading == pytest.approx(math.pi / 2)
