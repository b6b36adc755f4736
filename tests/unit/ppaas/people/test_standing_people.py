"""Standing people whom cameras do not see any more."""

from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import LOST, PREDICTED, SEEN, TrackedPerson
from ppaas.nodes.move_base.people import KEEP, SAME, STANDING, StandingPeople


def person(number, x, speed=0.0, state=SEEN):
    return TrackedPerson(number, Point(x, 0.0), Point(speed, 0.0), [0.01, 0.0, 0.0, 0.01], state=state)


def standing(*people, most=10):
    kept = StandingPeople(most)
    kept.take(people, 100.0)
    return kept


def test_positions_at_which_people_stood_are_kept_for_a_time():
    kept = standing(person(1, 1.0), person(2, 3.0, STANDING))
    kept.take([person(1, 1.4, state=PREDICTED)], 101.0)
    kept.take([], 102.0)
    assert kept.unseen([], 100.0 + KEEP) == ((1.0, 0.0),)
    assert kept.unseen([], 100.1 + KEEP) == ()


def test_people_who_were_not_seen_have_no_position():
    assert standing(person(1, 1.0, state=PREDICTED), person(2, 3.0, state=LOST)).unseen([], 100.0) == ()


def test_person_who_walks_on_is_forgotten():
    kept = standing(person(1, 1.0))
    kept.take([person(1, 1.2, 1.0)], 100.2)
    assert kept.unseen([], 100.2) == ()


def test_person_who_is_seen_again_under_another_identity_is_one_person():
    kept = standing(person(1, 1.0))
    assert kept.unseen([(1.0 + SAME, 0.0)], 100.0) == ()
    assert kept.unseen([(1.01 + SAME, 0.0)], 100.0) == ((1.0, 0.0),)


def test_people_who_were_not_seen_for_the_longest_time_are_forgotten_first():
    kept = standing(person(1, 1.0), person(2, 2.0), most=2)
    kept.take([person(1, 1.0)], 101.0)
    kept.take([person(3, 3.0)], 102.0)
    assert sorted(kept.unseen([], 102.0)) == [(1.0, 0.0), (3.0, 0.0)]
