"""Distance filter: beams that end at people around a robot."""

import math

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.particle_filter import ParticleFilter
from ppaas.localization.sensor_model import MANY, NEAR, ends_at_people
from tests.support.world.planar_world import walled_map

GRID = walled_map(12, 9, [])
LAYERS = build_layers(GRID)
HERE = Pose2D(3.0, 4.5, 0.3)
BESIDE = Pose2D(6.0, 1.2, 0.0)
"""A robot 1.1 m from the lower wall."""


def seen(people: int, others: int, away: float = 1.0) -> np.ndarray:
    """Return end points of beams at people at a distance, and of others at the left wall, as seen from `HERE`."""
    bearings = np.linspace(-0.6, 0.6, people)
    near = away * np.column_stack((np.cos(bearings), np.sin(bearings)))
    walls = np.column_stack((np.full(others, 0.05 - HERE.x), np.linspace(-1.5, 1.5, others)))
    c, s = math.cos(HERE.theta), math.sin(HERE.theta)
    return np.vstack((near, walls @ np.array(((c, -s), (s, c)))))


def test_beams_at_many_people_are_distinguished_from_beams_at_walls() -> None:
    np.testing.assert_array_equal(ends_at_people(HERE, seen(20, 30), LAYERS), np.arange(50) < 20)


@pytest.mark.parametrize("people", [0, 3, int(40 * MANY)])
def test_few_people_are_ignored(people: int) -> None:
    assert not ends_at_people(HERE, seen(people, 40 - people), LAYERS).any()


def test_near_walls_are_not_people() -> None:
    beside_the_wall = np.column_stack((np.linspace(-0.8, 0.8, 30), np.full(30, 0.1 - BESIDE.y)))
    assert not ends_at_people(BESIDE, beside_the_wall, LAYERS).any()
    assert ends_at_people(BESIDE, 0.6 * beside_the_wall, LAYERS).all()


def test_people_far_away_are_ignored() -> None:
    assert ends_at_people(HERE, seen(20, 30, NEAR - 0.1), LAYERS).any()
    assert not ends_at_people(HERE, seen(20, 30, NEAR + 0.1), LAYERS).any()


@pytest.mark.parametrize("walls", [10, 0])
@pytest.mark.parametrize("model", ["likelihood_field", "likelihood_field_prob"])
def test_people_before_a_wall_do_not_shift_the_pose_to_it(model: str, walls: int) -> None:
    row = np.column_stack((np.linspace(-0.8, 0.8, 30), np.full(30, 0.45 - BESIDE.y)))
    left = np.column_stack((np.full(walls, 0.1 - BESIDE.x), np.linspace(0.0, 1.0, walls)))
    localization = ParticleFilter(LAYERS, AmclParameters(laser_model_type=model))
    localization.initialise(BESIDE, np.diag((0.04, 0.04, 0.001)))
    for _ in range(10):
        pose = localization.update(Pose2D(0.0, 0.0), np.vstack((row, left)), 8.0).pose
    assert abs(pose.y - BESIDE.y) < 0.1
