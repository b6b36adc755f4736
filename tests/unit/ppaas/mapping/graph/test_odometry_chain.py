import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.graph import consistency as module
from ppaas.mapping.graph.consistency import OdometryChain, adjoints, largest_clique
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.planar_poses import compose, inverse, relative
from tests.reference.mapping import pose_graph as twin
from tests.support.world.pose_graphs import ODOMETRY_NOISE, walk


def test_poses_are_those_of_odometry():
    graph, _, _ = walk(77, 30)
    chain = OdometryChain(graph)
    assert chain.poses[:, :2] == pytest.approx(graph.poses[:, :2])
    a, b = np.array([3, 50]), np.array([40, 2])
    assert chain.relative(a, b)[:, :2] == pytest.approx(relative(graph.poses[a], graph.poses[b])[:, :2])


def test_covariance_is_that_of_drifting_odometry():
    graph, _, _ = walk(60, 0)
    chain, random, ends = OdometryChain(graph), np.random.default_rng(0), (np.array([5]), np.array([55]))
    steps, drifted = graph.edges.measurements[5:55], np.zeros((4000, 3))
    for step in steps:
        drifted = compose(drifted, step + random.normal(0.0, ODOMETRY_NOISE, (4000, 3)))
    for first, second, exact in ((*ends, drifted), (*ends[::-1], inverse(drifted))):
        motions = relative(chain.relative(first, second)[0], exact)
        sampled = np.cov(motions.T)
        expected = chain.covariances(first, second)[0]
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        assert sampled / scale == pytest.approx(expected / scale, abs=0.15)


def test_adjoint_carries_a_small_motion_into_the_common_frame():
    pose, motion = np.array([3.0, -2.0, 1.1]), np.array([1e-6, -2e-6, 3e-6])
    moved = compose(compose(pose, motion), inverse(pose))
    assert moved == pytest.approx(adjoints(pose) @ motion, rel=1e-5, abs=1e-11)


def test_missing_odometry_breaks_the_chain():
    graph, _, _ = walk(10, 0)
    graph.keep_edges(graph.edges.second != 4)
    assert OdometryChain(graph).parts.tolist() == [1] * 4 + [2] * 6


def test_edge_without_information_is_uncertain():
    graph = PoseGraph()
    for _ in range(2):
        graph.add_node((0.0, 0.0, 0.0))
    graph.add_edge(0, 1, (1.0, 0.0, 0.0), np.zeros((3, 3)), EdgeKind.ODOMETRY)
    assert (np.diag(OdometryChain(graph).covariances(np.array([0]), np.array([1]))[0]) > 1e5).all()


def random_graph(count, share, seed):
    upper = np.triu(np.random.default_rng(seed).random((count, count)) < share, 1)
    return upper | upper.T


@given(st.integers(0, 14), st.floats(0.0, 1.0), st.integers(0, 1000))
def test_clique_is_connected_and_as_large_as_the_twins(count, share, seed):
    connected = random_graph(count, share, seed)
    found = largest_clique(connected)
    assert len(found) == twin.largest_clique_size(connected)
    assert connected[np.ix_(found, found)].sum() == len(found) * (len(found) - 1)
    assert (np.diff(found) > 0).all()


def test_search_ends_after_its_limit(monkeypatch):
    monkeypatch.setattr(module, "_EXPANSIONS", 50)
    connected = random_graph(200, 0.7, 0)
    found = largest_clique(connected)
    assert len(found) > 5
    assert connected[np.ix_(found, found)].sum() == len(found) * (len(found) - 1)
