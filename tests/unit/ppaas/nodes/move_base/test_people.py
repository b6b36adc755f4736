import math

import pytest

from ppaas.errors import InvalidInput, InvalidParameter, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_msgs import People, Person
from ppaas.nodes.move_base.people import FASTEST, MOST_PEOPLE, SeenPeople, SocialLayerParameters
from ppaas.transforms.planar import TransformTree

ANN = Person("ann", Point(1.0, 0.0), Point(0.5, 0.0))


def seen(*people, frame="map", tree=None, **parameters):
    layer = SeenPeople(SocialLayerParameters(**parameters))
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
