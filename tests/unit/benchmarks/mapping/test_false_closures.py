import numpy as np

from benchmarks.mapping.map_errors import Closures, by_poses, by_relations
from ppaas.mapping.relations import Relations
from ppaas.planar_poses import relative

# Two laps of a circle of 3 m, 40 scans each.
ANGLES = np.linspace(0.0, 4.0 * np.pi, 80, endpoint=False)
TRUE = np.column_stack((3.0 * np.cos(ANGLES), 3.0 * np.sin(ANGLES), ANGLES + np.pi / 2.0))
STAMPS = 10.0 + 0.2 * np.arange(80)
SCANS = np.array([(2, 42), (12, 53), (25, 66)])


def closures():
    motions = relative(TRUE[SCANS[:, 0]], TRUE[SCANS[:, 1]])
    motions[1, 0] += 0.6
    return Closures(SCANS, motions, np.tile(1e4 * np.eye(2), (3, 1, 1)))


def test_an_edge_half_a_metre_off_the_true_poses_is_false():
    assert by_poses(closures(), TRUE) == (3, 3, 1)


def test_what_an_edge_leaves_open_is_not_false():
    found = closures()
    found.information[1] = np.diag((1.0, 1e4))
    assert by_poses(found, TRUE) == (3, 3, 0)


def test_edges_are_judged_by_relations_between_scans_near_their_ends():
    # The ends of the relations are a scan away, and the second relation is given backwards.
    ends = np.array([(1, 42), (52, 12)])
    relations = Relations(STAMPS[ends], relative(TRUE[ends[:, 0]], TRUE[ends[:, 1]]))
    assert by_relations(closures(), relations, STAMPS, TRUE + np.array((5.0, 1.0, 0.0))) == (3, 2, 1)
