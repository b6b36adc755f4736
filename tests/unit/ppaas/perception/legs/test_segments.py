"""Segments of a scan: where they begin and end, and their shapes."""

import math

import numpy as np
import pytest

from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.geometry import Pose2D
from ppaas.perception.legs.segments import segments_of
from tests.support.world.legs import NOTHING, reading_of, stand

HERE = Pose2D(6.0, 5.0, 0.4)


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
