import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.closures.candidates import find_candidates, path_covariances, search_window
from ppaas.mapping.closures.kernels.drift import path_moments
from ppaas.mapping.closures.parameters import ClosureParameters, DriftModel
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.planar_poses import relative
from tests.reference.mapping import closures as twin

PARAMETERS = ClosureParameters()
HEADING_ONLY = DriftModel(0.01, 0.0, 0.0, 0.0)


def line(n, closures=()):
    """Return the graph of a drive along x in steps of 1 m."""
    graph = PoseGraph()
    for k in range(n):
        graph.add_node((float(k), 0.0, 0.0))
    poses = graph.poses
    for k in range(n - 1):
        graph.add_edge(k, k + 1, relative(poses[k], poses[k + 1]), np.eye(3), EdgeKind.ODOMETRY)
    for i, j in closures:
        graph.add_edge(i, j, relative(poses[i], poses[j]), np.eye(3), EdgeKind.CLOSURE)
    return graph


def test_errors_of_the_heading_move_a_pose_across_the_path():
    graph = line(31)
    covariances, distance = path_covariances(graph.poses, graph.edges, 30, HEADING_ONLY)
    assert distance[0] == pytest.approx(30.0)
    assert covariances[0, 2, 2] == pytest.approx(0.01**2 * 30.0)
    # A random walk of the heading over a length L moves the end by σ² L³ / 3 across the path, and not along it.
    assert covariances[0, 1, 1] == pytest.approx(0.01**2 * 30.0**3 / 3.0, rel=0.01)
    assert covariances[0, 0, 0] == pytest.approx(0.0, abs=1e-12)


def test_covariance_agrees_with_drives_whose_headings_drift():
    rng = np.random.default_rng(0)
    steps, drives = 40, 4000
    turns = np.cumsum(rng.normal(0.0, 0.01, (drives, steps)), axis=1)
    ends = np.stack((np.cos(turns).sum(axis=1), np.sin(turns).sum(axis=1), turns[:, -1]), axis=1)
    graph = line(steps + 1)
    covariances, _ = path_covariances(graph.poses, graph.edges, steps, HEADING_ONLY)
    np.testing.assert_allclose(covariances[0][1:, 1:], np.cov(ends.T)[1:, 1:], rtol=0.1)


def test_systematic_error_grows_with_the_length():
    graph = line(21)
    covariances, _ = path_covariances(graph.poses, graph.edges, 20, DriftModel(0.0, 0.001, 0.0, 0.002))
    assert math.sqrt(covariances[0, 2, 2]) == pytest.approx(0.02)
    assert math.sqrt(covariances[0, 0, 0]) == pytest.approx(0.04)


def test_closure_shortens_the_path():
    graph = line(31, closures=[(2, 29)])
    _, distance = path_covariances(graph.poses, graph.edges, 30, HEADING_ONLY)
    assert distance[0] == pytest.approx(1.0 + 0.2 + 2.0)


def test_node_without_a_path_has_an_infinite_covariance_and_the_largest_window():
    graph = line(3)
    graph.add_node((9.0, 9.0, 0.0))
    covariances, distance = path_covariances(graph.poses, graph.edges, 0, HEADING_ONLY)
    assert np.isinf(distance[3])
    (x, y, _), _ = search_window(covariances[3], PARAMETERS)
    assert x == y == PARAMETERS.loop_search_maximum_distance


def test_window_is_long_along_the_largest_deviation():
    covariance = np.diag([0.01, 1.0, 0.0001])
    (x, y, turn), angle = search_window(covariance, PARAMETERS)
    assert x == pytest.approx(0.3 + 2.5)
    assert y == pytest.approx(0.3 + 0.25)
    assert turn == pytest.approx(0.05 + 0.025)
    assert abs(math.sin(angle)) == pytest.approx(1.0)


def test_candidates_are_near_older_submaps_and_the_nearest_comes_first():
    graph = PoseGraph()
    # There and back on a line: the last submap lies on the first ones.
    for x in [*range(30), *range(29, -1, -1)]:
        graph.add_node((float(x), 0.0, 0.0))
    poses = graph.poses
    for k in range(59):
        graph.add_edge(k, k + 1, relative(poses[k], poses[k + 1]), np.eye(3), EdgeKind.ODOMETRY)
    submaps = [Submap(k, k + 3) for k in range(0, 60, 3)]
    found = find_candidates(graph.poses, graph.edges, submaps, 19, PARAMETERS)
    assert found[0].target == 0
    assert 9 not in [candidate.target for candidate in found]
    assert all(candidate.target < 17 for candidate in found)
    assert find_candidates(graph.poses, graph.edges, submaps, 1, PARAMETERS) == []


def compressed(n, edges):
    """Return edges as rows of neighbours."""
    rows = [[] for _ in range(n)]
    for i, j, length, sign in edges:
        rows[i].append((j, length, sign))
        rows[j].append((i, length, -sign))
    starts = np.cumsum([0] + [len(row) for row in rows])
    flat = np.array([entry for row in rows for entry in row], float).reshape(-1, 3)
    return starts, flat[:, 0].astype(np.int64), flat[:, 1].copy(), flat[:, 2].copy()


@given(st.integers(0, 2**32 - 1))
def test_moments_equal_those_of_the_twin(seed):
    rng = np.random.default_rng(seed)
    n = 12
    edges = [(k, k + 1, rng.uniform(0.1, 1.0), 1.0) for k in range(n - 3)]
    edges += [(int(i), int(j), 0.2, 0.0) for i, j in rng.integers(0, n - 2, (3, 2)) if i != j]
    positions = rng.normal(size=(n, 2))
    found = path_moments(4, *compressed(n, edges), positions)
    np.testing.assert_allclose(found, twin.path_moments(4, n, edges, positions), atol=1e-9)
    assert np.isinf(found[n - 1, 0])
