"""Errors where true poses are known."""

import numpy as np

from benchmarks.mapping.map_errors import absolute_errors, random_relations
from ppaas.mapping.relations import score
from ppaas.planar_poses import compose

COUNT = 400
STAMPS = np.arange(COUNT, dtype=np.float64)
ANGLES = 4.0 * np.pi * STAMPS / COUNT
TRUE = np.column_stack((3.0 * np.cos(ANGLES), 3.0 * np.sin(ANGLES), ANGLES + np.pi / 2.0))


def test_relations_join_near_poses_of_different_passes():
    relations = random_relations(STAMPS, TRUE, 0, most=50)
    assert len(relations.poses) == 50
    assert (np.abs(np.diff(relations.stamps, axis=1)) > 100).all()
    assert np.hypot(*relations.poses[:, :2].T).max() < 3.0
    assert score(relations, STAMPS, TRUE).translations.max() < 1e-9


def test_absolute_errors_ignore_a_common_shift_and_turn():
    moved = compose(np.array((5.0, -3.0, 2.0)), TRUE)
    assert absolute_errors(TRUE, moved).max() < 1e-9
    moved[:, 0] *= 1.1
    assert 0.05 < absolute_errors(TRUE, moved).mean() < 0.5
