"""Errors of estimated poses and false closures, where the truth is known."""

import numpy as np

from benchmarks.mapping.map_errors import Closures, absolute_errors, by_poses, by_relations, random_relations
from ppaas.mapping.relations import Relations, score
from ppaas.planar_poses import compose, relative

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


# Two laps of a circle of 3 m, 40 scans each.
CLOSURE_ANGLES = np.linspace(0.0, 4.0 * np.pi, 80, endpoint=False)
TRUE_CLOSURES = np.column_stack(
    (3.0 * np.cos(CLOSURE_ANGLES), 3.0 * np.sin(CLOSURE_ANGLES), CLOSURE_ANGLES + np.pi / 2.0)
)
CLOSURE_STAMPS = 10.0 + 0.2 * np.arange(80)
SCANS = np.array([(2, 42), (12, 53), (25, 66)])


def closures():
    motions = relative(TRUE_CLOSURES[SCANS[:, 0]], TRUE_CLOSURES[SCANS[:, 1]])
    motions[1, 0] += 0.6
    return Closures(SCANS, motions, np.tile(1e4 * np.eye(2), (3, 1, 1)))


def test_an_edge_half_a_metre_off_the_true_poses_is_false():
    assert by_poses(closures(), TRUE_CLOSURES) == (3, 3, 1)


def test_what_an_edge_leaves_open_is_not_false():
    found = closures()
    found.information[1] = np.diag((1.0, 1e4))
    assert by_poses(found, TRUE_CLOSURES) == (3, 3, 0)


def test_edges_are_judged_by_relations_between_scans_near_their_ends():
    # The ends of the relations are a scan away, and the second relation is given backwards.
    ends = np.array([(1, 42), (52, 12)])
    relations = Relations(CLOSURE_STAMPS[ends], relative(TRUE_CLOSURES[ends[:, 0]], TRUE_CLOSURES[ends[:, 1]]))
    assert by_relations(closures(), relations, CLOSURE_STAMPS, TRUE_CLOSURES + np.array((5.0, 1.0, 0.0))) == (3, 2, 1)
