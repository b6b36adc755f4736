"""Space between people who stand and talk."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import LOST, PREDICTED, TrackedPerson
from ppaas.people.talking_groups import between, distances_to, groups_of, predicted, segments_of

COORDINATES = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))


def person(number: int, x: float, y: float, *, group: int = 0, vx: float = 0.0, state: str = PREDICTED):
    return TrackedPerson(number, Point(x, y), Point(vx, 0.0), [0.0] * 4, state=state, group=group)


def test_groups_have_two_members_or_more_and_nobody_who_is_lost():
    people = [
        person(1, 0.0, 0.0, group=1),
        person(2, 1.0, 0.0, group=1),
        person(3, 5.0, 0.0),
        person(4, 2.0, 0.0, group=2),
    ]
    people.append(person(5, 3.0, 0.0, group=2, state=LOST))
    (members,) = groups_of(people)
    assert members.tolist() == [[0.0, 0.0], [1.0, 0.0]]


def test_members_are_predicted_at_constant_velocity():
    assert predicted(person(1, 1.0, 2.0, vx=0.5), 2.0) == (2.0, 2.0)
    (members,) = groups_of([person(1, 0.0, 0.0, group=1, vx=0.5), person(2, 1.0, 0.0, group=1)], 1.0)
    assert members[0].tolist() == [0.5, 0.0]


def test_points_between_two_who_talk_are_evenly_spaced_without_the_two():
    points = between(np.array([[0.0, 0.0], [1.5, 0.0]]))
    assert points[:, 0].tolist() == pytest.approx([0.375, 0.75, 1.125])
    assert not points[:, 1].any()


def test_members_far_apart_have_no_space_between_them():
    members = np.array([[0.0, 0.0], [4.0, 0.0]])
    assert not len(segments_of(members)) and not len(between(members))
    assert np.isinf(distances_to(np.array([[2.0, 0.0]]), [members])).all()


def test_distance_is_that_to_the_nearest_segment():
    three = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    points = np.array([[0.5, 0.0], [0.5, -0.5], [-1.0, 0.0], [1.0, 1.0]])
    assert distances_to(points, [three]).tolist() == pytest.approx([0.0, 0.5, 1.0, 0.5**0.5])


@given(st.lists(COORDINATES, min_size=2, max_size=5))
def test_every_point_between_members_is_in_their_space(members):
    space = np.array(members) * 0.8
    assert (distances_to(between(space), [space]) < 1e-9).all()
