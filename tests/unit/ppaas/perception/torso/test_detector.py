"""Torso detector on images of a simulated camera."""

import math

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.perception.torso.detector import TorsoDetection, TorsoDetector, best_of, log_odds
from ppaas.perception.torso.parameters import TorsoDetectorParameters
from robots.sim.bodies.furniture import chair, coat_stand, column, table
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.depth.shapes import Shapes, box, shapes_of
from tests.support.world.depth_images import SMALL, image_of, person, view_of


def found_in(*parts: Shapes, model: DepthCameraModel = SMALL) -> list[TorsoDetection]:
    return TorsoDetector(view_of(model)).detect(image_of(*parts, model=model))


@pytest.mark.parametrize("facing", [0.0, 1.2, 2.2, math.pi])
@pytest.mark.parametrize(("x", "y"), [(1.6, 0.1), (3.0, -0.6), (4.8, 1.0)])
def test_a_person_who_stands_is_found(x: float, y: float, facing: float) -> None:
    [one] = found_in(person(x, y, facing))
    assert math.hypot(one.x - x, one.y - y) < 0.15
    assert one.top == pytest.approx(1.75, abs=0.26)
    assert one.score >= 0.5


def test_a_person_who_sits_is_found_and_a_chair_is_not() -> None:
    seat = Pose2D(2.6, 0.2, math.pi)
    [one] = found_in(person(*seat, sitting=True), chair(seat).shapes)
    assert math.hypot(one.x - 2.6, one.y - 0.2) < 0.15
    assert one.top < 1.5
    assert found_in(chair(seat).shapes) == []


def test_a_large_image_is_the_same_to_it() -> None:
    [one] = found_in(person(3.0, 0.5), model=DepthCameraModel(640, 480))
    assert math.hypot(one.x - 3.0, one.y - 0.5) < 0.15


def test_two_who_stand_side_by_side_are_two() -> None:
    assert len(found_in(person(3.0, -0.3), person(3.0, 0.3))) == 2


def test_a_person_behind_a_table_or_half_out_of_the_image_is_found() -> None:
    assert len(found_in(person(3.2, 0.0), table(Pose2D(2.3, 0.0, 1.57)).shapes)) == 1
    edge = 3.0 * math.tan(math.radians(28.5)) - 0.1
    assert len(found_in(person(3.0, edge))) == 1


@pytest.mark.parametrize(
    "thing",
    [
        coat_stand(Pose2D(2.5, 0.0, math.pi)).shapes, column(Pose2D(2.5, 0.0)).shapes,
        table(Pose2D(2.5, 0.0, 0.3)).shapes, shapes_of([], [box((2.6, 0.0, 1.0), (0.1, 3.0, 1.5))]),
    ],
    ids=["coat stand", "column", "table", "wall"],
)  # fmt: skip
def test_furniture_is_not_found(thing: Shapes) -> None:
    assert found_in(thing) == []


def test_positions_are_less_sure_along_the_line_of_sight_the_farther_they_are() -> None:
    [near], [far] = found_in(person(2.0, 0.0)), found_in(person(5.0, 0.0))
    assert far.covariance[0] > near.covariance[0] > near.covariance[4] > 0.0
    assert far.covariance[1] == pytest.approx(0.0, abs=1e-3)


def test_an_image_without_readings_shows_nobody() -> None:
    detector = TorsoDetector(view_of())
    assert detector.detect(np.zeros((240, 320), np.uint16)) == []
    assert detector.detect(np.full((240, 320), np.nan, np.float32)) == []
    assert detector.detect(np.full((240, 320), np.inf, np.float32)) == []
    with pytest.raises(InvalidInput, match="320×240"):
        detector.detect(np.zeros((240, 320), np.int32))


@pytest.mark.parametrize("seed", range(3))
def test_any_image_gives_finite_positions(seed: int) -> None:
    rng = np.random.default_rng(seed)
    noise = rng.integers(0, 8000, (240, 320)).astype(np.uint16)
    seen = image_of(person(2.0, 0.0), coat_stand(Pose2D(3.0, 1.0)).shapes)
    image = np.where(rng.random(seen.shape) < (0.1, 0.3, 1.0)[seed], noise, seen)
    own = TorsoDetectorParameters(threshold=0.0)
    found = TorsoDetector(view_of(), own).detect(image)
    assert len(found) > 0 or seed == 2
    for one in found:
        assert all(map(math.isfinite, (one.x, one.y, one.z, one.score, *one.covariance)))
        assert 0.0 <= one.score <= 1.0


def test_of_places_near_each_other_the_best_is_kept() -> None:
    places = np.array([(1.0, 0.0), (1.1, 0.0), (3.0, 0.0), (5.0, 0.0)], np.float32)
    odds = np.array([0.5, 2.0, 1.0, -3.0], np.float32)
    assert best_of(places, odds, -1.0, 0.4) == [1, 2]
    assert log_odds(0.5) == 0.0
    assert (log_odds(0.0), log_odds(1.0)) == (-math.inf, math.inf)
