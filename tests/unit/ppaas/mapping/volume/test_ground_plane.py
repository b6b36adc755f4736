"""Ground filter: floors, tables, and clouds without a floor."""

import numpy as np
import pytest

from ppaas.errors import InvalidParameter
from ppaas.mapping.volume.ground_plane import GroundFilterParameters, ground_mask

DEFAULTS = GroundFilterParameters()


def level(height, count, seed=1, tilt=0.0):
    random = np.random.default_rng(seed)
    points = random.uniform(-2.0, 2.0, (count, 3))
    points[:, 2] = height + tilt * points[:, 0] + random.normal(0.0, 0.01, count)
    return points.astype(np.float32)


def wall(count):
    points = level(0.0, count, 3)
    return points[:, [2, 1, 0]] + np.array([2.0, 0.0, 2.0], np.float32)


def test_points_of_the_floor_are_found_and_no_others():
    mask = ground_mask(np.concatenate((level(0.0, 400), wall(400))), DEFAULTS)
    assert mask[:400].mean() > 0.99
    assert mask[400:].mean() < 0.05


def test_a_table_is_no_floor_even_if_it_is_larger():
    mask = ground_mask(np.concatenate((level(0.7, 800), level(0.02, 200, 2))), DEFAULTS)
    assert not mask[:800].any()
    assert mask[800:].mean() > 0.99


def test_a_floor_may_be_tilted_within_the_angle():
    for tilt, found in ((0.1, True), (0.6, False)):
        mask = ground_mask(level(0.0, 400, tilt=tilt), DEFAULTS)
        assert bool(mask.mean() > 0.95) is found


def test_without_a_plane_the_points_near_the_height_of_the_floor_are_taken():
    points = wall(400)
    mask = ground_mask(points, DEFAULTS)
    assert np.array_equal(mask, np.abs(points[:, 2]) <= DEFAULTS.plane_distance)


def test_small_clouds_and_points_that_are_not_finite_have_no_floor():
    assert not ground_mask(level(0.0, 20), DEFAULTS).any()
    points = level(0.0, 100)
    points[:30, 1] = np.nan
    assert not ground_mask(points, DEFAULTS)[:30].any()


@pytest.mark.parametrize("wrong", [{"distance": 0.0}, {"angle": 2.0}, {"plane_distance": -1.0}])
def test_invalid_parameters_are_refused(wrong):
    with pytest.raises(InvalidParameter):
        GroundFilterParameters(**wrong)
