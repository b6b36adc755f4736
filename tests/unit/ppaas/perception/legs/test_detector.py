"""Leg detector: people who stand and walk are found, furniture and walls are not."""

import math

import numpy as np
import pytest

from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.perception.legs.detector import LegDetection, LegDetector, MapInFrame
from ppaas.perception.legs.parameters import LegDetectorParameters
from ppaas.perception.legs.segments import segments_of
from tests.support.world.legs import CHAIR_LEG, LAYERS, NOTHING, chair, reading_of, stand, walk

HERE = Pose2D(6.0, 5.0, 0.4)
MAP = MapInFrame(LAYERS, Pose2D(0.0, 0.0))


def detector() -> LegDetector:
    return LegDetector(LegDetectorParameters())


def near(found: list[LegDetection], x: float, y: float) -> list[LegDetection]:
    return [each for each in found if math.hypot(each.x - x, each.y - y) < 0.3]


def test_people_who_stand_are_located_from_almost_any_side():
    """A leg that is half behind the other may make them one segment that looks like neither one leg nor two."""
    rng, located = np.random.default_rng(0), 0
    for _ in range(300):
        bearing, facing = rng.uniform(-math.pi, math.pi, 2).tolist()
        away = float(rng.uniform(0.8, 2.5))
        x, y = HERE.x + away * math.cos(bearing), HERE.y + away * math.sin(bearing)
        found = detector().detect(reading_of(HERE, stand(x, y, facing)), 0.0, MAP)
        people = near(found, x, y)
        located += len(people) == 1
        assert all(math.hypot(each.x - x, each.y - y) < 3.0 * each.sigma for each in people)
        assert [each for each in found if each.may_begin and each not in people] == []
    assert located >= 285


def test_two_people_are_two_detections():
    found = detector().detect(reading_of(HERE, np.vstack((stand(7.5, 5.0, 1.0), stand(7.5, 6.0, 2.0)))), 0.0, MAP)
    assert [len(near(found, 7.5, y)) for y in (5.0, 6.0)] == [1, 1]


def test_chairs_poles_and_walls_begin_no_track():
    furniture = (chair(7.0, 6.5), CHAIR_LEG), (np.array([(4.0, 4.0)]), 0.2)
    for seed in range(10):
        found = detector().detect(reading_of(HERE, NOTHING, *furniture, seed=seed), 0.0, MAP)
        assert [each for each in found if each.may_begin] == []


def test_robot_that_drives_is_no_person():
    """It has the width of two legs side by side, but it is round."""
    moving = detector()
    for step in range(20):
        robot = np.array([(5.0 + 0.05 * step, 7.5)]), 0.18
        found = moving.detect(reading_of(HERE, NOTHING, robot, seed=step), 0.1 * step, MAP)
        assert [each for each in found if each.may_begin] == []


def test_walls_of_the_map_are_left_out_only_where_the_robot_is_localized():
    by_the_wall = stand(11.8, 5.0, 0.0)
    reading = reading_of(Pose2D(10.0, 5.0), by_the_wall)
    assert near(detector().detect(reading, 0.0), 11.8, 5.0) != []
    elsewhere = MapInFrame(LAYERS, Pose2D(40.0, 0.0))
    assert detector().detect(reading, 0.0, elsewhere) == []


def test_person_who_walks_scores_higher_than_the_same_legs_at_rest():
    walking, standing = detector(), detector()
    scores: dict[str, list[float]] = {"walks": [], "stands": []}
    for step in range(20):
        seconds = 0.1 * step
        legs = walk((5.0, 7.0), 0.0, seconds)
        scores["walks"] += [e.score for e in walking.detect(reading_of(HERE, legs, seed=step), seconds, MAP)]
        found = standing.detect(reading_of(HERE, stand(6.0, 7.0, 1.57), seed=step), seconds, MAP)
        scores["stands"] += [e.score for e in near(found, 6.0, 7.0)]
    assert np.mean(scores["walks"][10:]) > 0.9
    assert np.mean(scores["stands"][10:]) > 0.7


def test_thin_legs_between_whose_beams_earlier_scans_saw_have_not_moved():
    far = detector()
    for seed in range(30):
        laser = Pose2D(6.0 + 0.02 * seed, 5.0, 0.4)
        found = far.detect(reading_of(laser, NOTHING, (chair(10.5, 5.0), CHAIR_LEG), seed=seed), 0.1 * seed, MAP)
        assert [each for each in found if each.may_begin] == []


def test_leg_alone_is_detected_but_begins_no_track():
    [leg] = near(detector().detect(reading_of(HERE, stand(7.5, 5.0)[:1]), 0.0, MAP), 7.5, 5.1)
    assert not leg.may_begin
    assert leg.score < 0.7


def test_scan_without_readings_has_no_people():
    blind = LaserReading(HERE, np.linspace(-1.0, 1.0, 60), np.full(60, np.nan))
    assert detector().detect(blind, 0.0, MAP) == []


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"max_range": 0.0}, "above 0"),
        ({"max_range": 99.0}, "at most 30 m"),
        ({"min_reliability": 0.9}, "from 0 to 1"),
        ({"min_range": 6.0}, "below max_range"),
        ({"connection_threshold": math.nan}, "finite"),
    ],
)
def test_parameters_out_of_range_are_refused(wrong, text):
    with pytest.raises(InvalidParameter, match=text):
        LegDetectorParameters(**wrong)


def test_scan_whose_beams_have_one_angle_shows_nobody():
    reading = LaserReading(Pose2D(0.0, 0.0), np.zeros(10), np.full(10, 2.0))
    with np.errstate(divide="raise", invalid="raise"):
        assert detector().detect(reading, 0.0) == []


def reading(ranges: list[float], increment: float = 0.05, first: float = -0.2) -> LaserReading:
    return LaserReading(Pose2D(0.0, 0.0), first + increment * np.arange(len(ranges)), np.array(ranges))


@pytest.mark.parametrize("bearing", np.linspace(-math.pi, math.pi, 9).tolist())
def test_two_legs_are_two_segments_as_wide_as_a_leg_wherever_the_scan_begins(bearing):
    person = HERE @ Pose2D(1.5 * math.cos(bearing), 1.5 * math.sin(bearing))
    facing = HERE.theta + bearing
    segments = segments_of(reading_of(HERE, stand(person.x, person.y, facing)), gap=0.1, longest=3.0)
    assert len(segments) == 2
    assert segments.width == pytest.approx(0.12, abs=0.04)
    assert segments.range == pytest.approx(1.5, abs=0.1)
    assert (segments.gap_before > 1.0).all()
    assert (segments.gap_after > 1.0).all()


def test_bend_tells_a_round_object_from_a_flat_one():
    flat = [1.0 / math.cos(angle) for angle in (-0.06, -0.03, 0.0, 0.03, 0.06)]
    round_ = [1.03, 1.01, 1.0, 1.01, 1.03]
    [board, pole] = (segments_of(reading(shape, 0.03, -0.06), gap=0.1, longest=3.0) for shape in (flat, round_))
    assert board.bend[0] < 0.003
    assert pole.bend[0] > 0.02
    assert pole.depth[0] == pytest.approx(0.03)


def test_one_beam_without_reading_does_not_end_a_segment_but_two_do():
    once = segments_of(reading([1.0, 1.0, math.nan, 1.0, 1.0], 0.02), gap=0.1, longest=3.0)
    assert once.count.tolist() == [4]
    twice = segments_of(reading([1.0, 1.0, math.nan, math.nan, 1.0], 0.02), gap=0.1, longest=3.0)
    assert twice.count.tolist() == [2, 1]


def test_edge_at_the_end_of_the_field_of_view_is_hidden():
    segments = segments_of(reading([1.0, 1.0, math.inf, 2.0, 1.0]), gap=0.1, longest=3.0)
    assert segments.gap_before.tolist() == [-1.0, math.inf, 1.0]
    assert segments.gap_after.tolist() == [math.inf, -1.0, -1.0]


def test_scan_without_hits_has_no_segments():
    for nothing in ([math.inf] * 5, [math.nan] * 5, [0.0] * 5, [4.0] * 5):
        assert len(segments_of(reading(nothing), gap=0.1, longest=3.0)) == 0
    assert len(segments_of(reading_of(HERE, NOTHING), gap=0.1, longest=1.0)) == 0
