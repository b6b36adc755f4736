"""Beams and hits that a sensor model chooses from one scan, and beams that end at people around a robot."""

import math

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.particle_filter import ParticleFilter
from ppaas.localization.sensor_model import MANY, NEAR, ends_at_people, sensor_model
from ppaas.thread_budget import one_thread
from tests.support.world.planar_world import World, walled_map

LAYERS = build_layers(walled_map(6, 4, [(3.0, 1.0, 3.4, 2.0)]))
LASER = Pose2D(0.1, 0.0, 0.3)


@pytest.mark.parametrize("most", [5, 60, 1000])
@pytest.mark.parametrize("kind", ["likelihood_field", "likelihood_field_prob", "beam"])
def test_beams_and_hits_are_those_that_are_chosen_one_by_one(kind: str, most: int) -> None:
    model = sensor_model(LAYERS, AmclParameters(laser_model_type=kind, laser_max_range=3.0), one_thread)
    scan = World(LAYERS.grid, Pose2D(1.5, 2.0, 0.2)).scan(0.0)
    beams, hits = model.beams_and_hits(scan, LASER, most)
    np.testing.assert_array_equal(beams, model.beams(scan, LASER))
    np.testing.assert_array_equal(hits, model.hits(scan, LASER, most))
    assert 0 < len(hits) <= most


GRID = walled_map(12, 9, [])
CROWDED_LAYERS = build_layers(GRID)
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
    np.testing.assert_array_equal(ends_at_people(HERE, seen(20, 30), CROWDED_LAYERS), np.arange(50) < 20)


@pytest.mark.parametrize("people", [0, 3, int(40 * MANY)])
def test_few_people_are_ignored(people: int) -> None:
    assert not ends_at_people(HERE, seen(people, 40 - people), CROWDED_LAYERS).any()


def test_near_walls_are_not_people() -> None:
    beside_the_wall = np.column_stack((np.linspace(-0.8, 0.8, 30), np.full(30, 0.1 - BESIDE.y)))
    assert not ends_at_people(BESIDE, beside_the_wall, CROWDED_LAYERS).any()
    assert ends_at_people(BESIDE, 0.6 * beside_the_wall, CROWDED_LAYERS).all()


def test_people_far_away_are_ignored() -> None:
    assert ends_at_people(HERE, seen(20, 30, NEAR - 0.1), CROWDED_LAYERS).any()
    assert not ends_at_people(HERE, seen(20, 30, NEAR + 0.1), CROWDED_LAYERS).any()


@pytest.mark.parametrize("walls", [10, 0])
@pytest.mark.parametrize("model", ["likelihood_field", "likelihood_field_prob"])
def test_people_before_a_wall_do_not_shift_the_pose_to_it(model: str, walls: int) -> None:
    row = np.column_stack((np.linspace(-0.8, 0.8, 30), np.full(30, 0.45 - BESIDE.y)))
    left = np.column_stack((np.full(walls, 0.1 - BESIDE.x), np.linspace(0.0, 1.0, walls)))
    localization = ParticleFilter(CROWDED_LAYERS, AmclParameters(laser_model_type=model))
    localization.initialise(BESIDE, np.diag((0.04, 0.04, 0.001)))
    for _ in range(10):
        pose = localization.update(Pose2D(0.0, 0.0), np.vstack((row, left)), 8.0).pose
    assert abs(pose.y - BESIDE.y) < 0.1
