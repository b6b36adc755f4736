import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.mapping.alignment import Aligned
from ppaas.mapping.closures.kernels.visibility import agreement
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.tracking_doubt import CONTRADICTED, SCANS, TrackingDoubt
from tests.reference.mapping import closures as twin
from tests.support.world.room_scans import LASER, scan_at

STEP = Pose2D(0.1, 0.0, 0.0)


@pytest.fixture
def doubt() -> TrackingDoubt:
    return TrackingDoubt(LASER)


def noted(doubt: TrackingDoubt, count: int, confirmed: float, step: Pose2D = STEP) -> list[bool]:
    """Note scans of a room along which the robot drives, and return after which it is lost."""
    lost = []
    for number in range(count):
        doubt.note(scan_at(Pose2D(0.1 * number - 1.0, 0.0, 0.0), seed=number), step, 0.9, confirmed)
        lost.append(doubt.is_lost)
    return lost


def test_a_robot_whose_scans_contradict_the_map_but_not_each_other_is_lost(doubt):
    assert noted(doubt, 6, 0.3) == [False] * SCANS + [True]
    assert not doubt.is_raised


def test_a_robot_that_stands_is_not_lost(doubt):
    assert noted(doubt, 50, 0.3, Pose2D(0.0, 0.0, 0.0)) == [False] * 50
    assert doubt.is_raised


def test_a_scan_that_fits_ends_the_doubt(doubt):
    noted(doubt, 5, 0.3)
    noted(doubt, 1, 0.9)
    assert not doubt.is_raised
    assert not any(noted(doubt, 5, 0.3))


def test_in_a_crowd_scans_contradict_each_other_too(doubt):
    random = np.random.default_rng(0)
    for number in range(20):
        scan = scan_at(Pose2D(0.1 * number - 1.0, 0.0, 0.0), seed=number)
        for begin in random.integers(0, LASER.beams - LASER.beams // 6, 3):
            scan.points[begin : begin + LASER.beams // 6] *= random.uniform(0.2, 0.5)
        doubt.note(scan, STEP, 0.3, 0.5)
        assert not doubt.is_lost


@pytest.mark.parametrize(("usual", "contradicts"), [(0.9, True), (0.3, False)])
def test_where_few_points_usually_fit_a_scan_that_fits_poorly_contradicts_nothing(doubt, usual, contradicts):
    frames = KeyFrames(LASER)
    frames.add(scan_at(Pose2D(0.0, 0.0, 0.0)), 0, Pose2D(0.0, 0.0, 0.0), np.zeros(6))
    for _ in range(30):
        doubt.note(scan_at(Pose2D(0.0, 0.0, 0.0)), STEP, usual, 1.0)
    elsewhere = Aligned(Pose2D(1.5, 0.5, 1.0), np.zeros(6), 0.2, 10)
    confirmed = doubt.confirmation(scan_at(Pose2D(0.0, 0.0, 0.0)), elsewhere, frames, frames.latest(1))
    assert (confirmed < CONTRADICTED) == contradicts


BEAMS, LASER_STEP = 60, math.radians(3.0)


def scan(ranges):
    angles = -math.pi / 2 + LASER_STEP * np.arange(BEAMS)
    return (ranges[:, None] * np.stack((np.cos(angles), np.sin(angles)), axis=1)).astype(np.float32)


@given(st.integers(0, 2**32 - 1))
def test_numbers_equal_those_of_the_twin(seed):
    rng = np.random.default_rng(seed)
    one, two = scan(rng.uniform(1, 4, BEAMS)), scan(rng.uniform(1, 4, BEAMS))
    valid, other = rng.random(BEAMS) < 0.9, rng.random(BEAMS) < 0.9
    given = (one, valid, two, other, rng.normal(size=3), -math.pi / 2, LASER_STEP, 0.3)
    assert agreement(*given) == twin.agreement(*given)


def test_wall_within_free_space_is_contradicted_and_hidden_wall_is_not():
    near, far, valid = scan(np.full(BEAMS, 2.0)), scan(np.full(BEAMS, 3.0)), np.ones(BEAMS, bool)
    here = np.zeros(3)
    assert agreement(near, valid, far, valid, here, -math.pi / 2, LASER_STEP, 0.3) == (0, BEAMS - 2)
    assert agreement(far, valid, near, valid, here, -math.pi / 2, LASER_STEP, 0.3) == (0, 0)
    assert agreement(near, valid, near, valid, here, -math.pi / 2, LASER_STEP, 0.3) == (BEAMS - 2, 0)
