import math

import msgspec
import pytest

from ppaas.errors import InvalidInput, InvalidParameter, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import LOST, PREDICTED, SEEN, PeopleState, TrackedPerson
from ppaas.messages.people_msgs import People, Person
from ppaas.nodes.move_base.people import (
    BODY,
    COORDINATED,
    FASTEST,
    KEEP,
    MOST_PEOPLE,
    SAME,
    STANDING,
    RecentPeople,
    SocialLayerParameters,
    StandingPeople,
)
from ppaas.transforms.planar import TransformTree

ANN = Person("ann", Point(1.0, 0.0), Point(0.5, 0.0))


def seen(*people, frame="map", tree=None, **parameters):
    layer = RecentPeople(SocialLayerParameters(**parameters))
    layer.take(People(Header(frame_id=frame), list(people)), tree or TransformTree(), 100.0)
    return layer


def test_people_are_kept_for_the_keep_time():
    layer = seen(ANN, keep_time=0.5)
    assert layer.now(100.5) == ((1.0, 0.0, 0.5, 0.0),)
    assert layer.now(100.6) == ()
    layer.take(People(Header(), []), TransformTree(), 100.2)
    assert layer.now(100.3) == ()


def test_disabled_layer_has_no_people():
    assert seen(ANN, enabled=False).now(100.0) == ()


def test_people_are_transformed_into_the_map_frame():
    tree = TransformTree()
    tree.set("map", "base_link", Pose2D(2.0, 3.0, math.pi / 2), stamp=99.0)
    (person,) = seen(ANN, frame="/base_link", tree=tree).now(100.0)
    assert person == pytest.approx((2.0, 4.0, 0.0, 0.5), abs=1e-9)
    with pytest.raises(TransformError):
        seen(ANN, frame="camera", tree=tree)


def test_velocity_of_people_is_limited():
    (person,) = seen(Person("bob", Point(0.0, 0.0), Point(-30.0, 40.0))).now(100.0)
    assert (person.vx, person.vy) == pytest.approx((-0.6 * FASTEST, 0.8 * FASTEST))


@pytest.mark.parametrize("wrong", [Point(math.nan, 0.0), Point(0.0, math.inf)])
def test_non_finite_people_are_refused_and_earlier_ones_stay(wrong):
    layer = seen(ANN)
    for person in (Person("bob", wrong), Person("bob", Point(0.0, 0.0), wrong)):
        with pytest.raises(InvalidInput, match="bob"):
            layer.take(People(Header(), [person]), TransformTree(), 100.1)
    assert len(layer.now(100.1)) == 1


def test_too_many_people_are_refused():
    with pytest.raises(InvalidInput, match=str(MOST_PEOPLE)):
        seen(*[ANN] * (MOST_PEOPLE + 1))


@pytest.mark.parametrize("wrong", [{"keep_time": 0.0}, {"amplitude": 254.0}, {"cutoff": -1.0}])
def test_parameters_out_of_range_are_refused_by_name(wrong):
    with pytest.raises(InvalidParameter, match=next(iter(wrong))):
        SocialLayerParameters(**wrong)


# -- people of the coordinator -----------------------------------------------------------------------------------------


def coordinated(*people, **parameters):
    layer = RecentPeople(SocialLayerParameters(**parameters))
    layer.take_state(PeopleState(Header(frame_id="map"), len(people), list(people)), 100.0)
    return layer


def tracked(x=1.0, vx=0.5, *, number=1, state=SEEN, group=0):
    return TrackedPerson(number, Point(x, 0.0), Point(vx, 0.0), [0.01, 0.0, 0.0, 0.01], state=state, group=group)


def test_people_of_the_coordinator_are_predicted_until_its_message_is_out_of_date():
    layer = coordinated(tracked(), tracked(state=LOST, number=2))
    assert layer.now(100.0) == ((1.0, 0.0, 0.5, 0.0),)
    assert layer.now(100.5)[0] == pytest.approx((1.2, 0.0, 0.5, 0.0))
    assert layer.now(100.59) == layer.now(100.5)
    assert layer.now(100.0 + COORDINATED + 0.1) == ()


def test_people_of_both_topics_are_kept():
    layer = coordinated(tracked())
    layer.take(People(Header(), [ANN]), TransformTree(), 100.0)
    assert len(layer.now(100.0)) == 2


def test_points_between_people_who_talk_are_known():
    talking = coordinated(tracked(0.0, 0.0, group=1), tracked(1.0, 0.0, number=2, group=1))
    assert [point.x for point in talking.between(100.0)] == pytest.approx([1 / 3, 2 / 3])
    assert talking.between(102.0) == () == coordinated(tracked(), tracked(2.0, number=2)).between(100.0)


@pytest.mark.parametrize("wrong", [tracked(math.nan), tracked(vx=math.inf)])
def test_non_finite_people_of_the_coordinator_are_refused_and_earlier_ones_stay(wrong):
    layer = coordinated(tracked())
    with pytest.raises(InvalidInput, match="person 1"):
        layer.take_state(PeopleState(Header(), 1, [wrong]), 100.1)
    with pytest.raises(InvalidInput, match=str(MOST_PEOPLE)):
        layer.take_state(PeopleState(Header(), 1, [tracked()] * (MOST_PEOPLE + 1)), 100.1)
    assert len(layer.now(100.1)) == 1


def test_bodies_are_those_of_people_whose_positions_are_known_well():
    hidden = tracked(2.0, number=2, state=PREDICTED)
    layer = coordinated(
        tracked(), msgspec.structs.replace(hidden, covariance=[0.5, 0.0, 0.0, 0.5]), tracked(state=LOST)
    )
    (body,) = layer.bodies(100.4)
    assert body == pytest.approx((1.2, 0.0, 0.5, 0.0, BODY))
    assert len(coordinated(hidden).bodies(100.0)) == 1
    assert coordinated(tracked(), enabled=False).bodies(100.0) == () == layer.bodies(102.0)


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
