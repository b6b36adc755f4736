"""Nodes that leave a pose graph, compared with the Schur complement of the normal equations."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.lifelong.marginalisation import MOST_CLOSURES, UncertainStep, without_nodes
from ppaas.planar_poses import compose, inverse, relative
from tests.support.budget import examples


def walk(count: int, seed: int) -> PoseGraph:
    """Return a chain of nodes at random poses, whose edges fit them exactly."""
    random, graph = np.random.default_rng(seed), PoseGraph()
    for node in range(count):
        graph.add_node(random.uniform((-3.0, -3.0, -3.0), (3.0, 3.0, 3.0)))
        if node:
            join(graph, node - 1, node, EdgeKind.ODOMETRY, random)
    return graph


def join(graph: PoseGraph, first: int, second: int, kind: EdgeKind, random: np.random.Generator) -> None:
    root = random.uniform(-1.0, 1.0, size=(3, 3)) + 4.0 * np.eye(3)  # far from singular, unlike with normal numbers
    graph.add_edge(first, second, relative(*graph.poses[[first, second]]), 10.0 * root @ root.T, kind)


def covariance(graph: PoseGraph) -> np.ndarray:
    """Return the covariance of all nodes but the first, which is fixed, in the frames of the map."""
    size, edges = 3 * graph.node_count, graph.edges
    normal = np.zeros((size, size))
    for first, second, _, information, _ in zip(*edges, strict=True):
        jacobian = np.zeros((3, size))
        for node in (first, second):
            for axis in range(3):
                off = np.zeros((2, graph.node_count, 3))
                off[:, node, axis] = 1e-6, -1e-6
                ahead, behind = (relative(*(graph.poses + one)[[first, second]]) for one in off)
                jacobian[:, 3 * node + axis] = (ahead - behind) / 2e-6
        normal += jacobian.T @ information @ jacobian
    return np.linalg.inv(normal[3:, 3:])


@settings(max_examples=examples(20))
@given(st.integers(0, 1000))
def test_nodes_of_a_chain_are_removed_exactly(seed):
    graph, removed = walk(7, seed), np.zeros(7, np.bool_)
    removed[[2, 3, 5]] = True
    thinned = without_nodes(graph, removed)
    kept = np.repeat(~removed[1:], 3)
    np.testing.assert_allclose(covariance(thinned), covariance(graph)[np.ix_(kept, kept)], rtol=1e-4, atol=1e-8)
    np.testing.assert_array_equal(thinned.poses, graph.poses[~removed])
    assert (thinned.edges.second - thinned.edges.first).tolist() == [1, 1, 1]
    assert set(thinned.edges.kinds.tolist()) == {EdgeKind.ODOMETRY}


@settings(max_examples=examples(20))
@given(st.integers(0, 1000))
def test_a_node_with_closures_leaves_edges_that_are_never_too_certain(seed):
    random, graph = np.random.default_rng(seed), walk(9, seed)
    for other in (0, 2, 8):
        join(graph, other, 5, EdgeKind.CLOSURE, random)
    removed = np.arange(9) == 5
    thinned = without_nodes(graph, removed)
    found, kept = covariance(thinned), np.repeat(~removed[1:], 3)
    before = covariance(graph)[np.ix_(kept, kept)]
    assert np.trace(found) >= 0.6 * np.trace(before)
    edges = thinned.edges
    np.testing.assert_allclose(
        edges.measurements, relative(thinned.poses[edges.first], thinned.poses[edges.second]), atol=1e-9
    )
    assert np.all(edges.first < edges.second)
    assert thinned.edge_count == graph.edge_count - 1


def test_the_first_node_of_a_chain_passes_its_edges_on():
    graph, random = walk(5, 1), np.random.default_rng(1)
    join(graph, 0, 4, EdgeKind.CLOSURE, random)
    thinned = without_nodes(graph, np.arange(5) == 0)
    ends = set(zip(thinned.edges.first.tolist(), thinned.edges.second.tolist(), strict=True))
    assert ends == {(0, 1), (1, 2), (2, 3), (0, 3)}
    assert thinned.node_count == 4


def test_of_equal_edges_the_most_certain_one_is_kept():
    graph, random = walk(4, 2), np.random.default_rng(2)
    for node in (1, 2):
        join(graph, 0, node, EdgeKind.CLOSURE, random)
    thinned = without_nodes(graph, np.array([False, True, False, False]))
    pairs = list(zip(thinned.edges.first.tolist(), thinned.edges.second.tolist(), thinned.edges.kinds, strict=True))
    assert len(set(pairs)) == len(pairs)


def test_closures_of_a_node_stay_few_and_chains_connected():
    count = 60
    graph, random = walk(count, 3), np.random.default_rng(3)
    for first in range(count - 20):
        join(graph, first, count - 1 - first % 10, EdgeKind.CLOSURE, random)
    removed = np.zeros(count, np.bool_)
    removed[1:40] = True
    edges = without_nodes(graph, removed).edges
    closures = edges.kinds == EdgeKind.CLOSURE
    ends = np.concatenate((edges.first[closures], edges.second[closures]))
    assert np.bincount(ends).max() <= MOST_CLOSURES + 1
    assert (~closures).sum() == count - 39 - 1


def test_a_chain_that_only_a_closure_connects_stays_connected():
    graph, random = PoseGraph(), np.random.default_rng(4)
    for pose in random.uniform(-1.0, 1.0, (12, 3)):
        graph.add_node(pose)
    for node in range(11):
        if node != 5:
            join(graph, node, node + 1, EdgeKind.ODOMETRY, random)
    for node in range(6):
        for other in range(6, 12):
            join(graph, node, other, EdgeKind.CLOSURE, random)
    thinned = without_nodes(graph, np.isin(np.arange(12), (0, 1, 2, 3, 4, 6, 7, 8, 9, 10)))
    assert (thinned.node_count, thinned.edge_count) == (2, 1)


@pytest.mark.parametrize("least", [0.0, -1e-3])
def test_edges_that_determine_nothing_in_one_direction_are_the_least_certain(least):
    graph, removed = walk(5, 6), np.arange(5) == 2
    root = np.linalg.qr(np.random.default_rng(6).normal(size=(3, 3)))[0]
    weak = root @ np.diag((least, 1e4, 1e4)) @ root.T  # slightly negative: rounded to float32
    for first in (1, 3):
        graph.add_edge(first, 4, relative(*graph.poses[[first, 4]]), weak, EdgeKind.CLOSURE)
    graph.add_edge(2, 4, relative(*graph.poses[[2, 4]]), 100.0 * np.eye(3), EdgeKind.CLOSURE)
    edges = without_nodes(graph, removed).edges
    assert np.linalg.eigvalsh(edges.information).min() > 0.0
    traces = np.trace(edges.information[edges.kinds == EdgeKind.CLOSURE], axis1=1, axis2=2)
    assert traces.min() < 300.0  # the edge through the removed node has replaced a weak one
    assert traces.max() == pytest.approx(2e4, rel=1e-3)


@pytest.mark.parametrize("removed", [[], [1]])
def test_the_graph_itself_is_unchanged(removed):
    graph = walk(4, 5)
    edges = [array.copy() for array in graph.edges]
    without_nodes(graph, np.isin(np.arange(4), removed))
    for array, before in zip(graph.edges, edges, strict=True):
        np.testing.assert_array_equal(array, before)


COVARIANCE = np.array([(4e-4, 1e-4, 2e-5), (1e-4, 9e-4, -3e-5), (2e-5, -3e-5, 1e-4)])
poses = st.tuples(*[st.floats(-5.0, 5.0)] * 2, st.floats(-3.1, 3.1)).map(np.array)


def samples(step: UncertainStep, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).multivariate_normal(step.measurement, step.covariance, 10_000)


def assert_spread(found: UncertainStep, drawn: np.ndarray) -> None:
    off = drawn - found.measurement
    off[:, 2] = (off[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    expected = np.cov(off.T)
    scale = np.sqrt(np.diag(expected))
    assert np.abs(found.covariance - expected).max(initial=0.0) <= 0.08 * scale.max() ** 2
    assert np.all(np.abs(off.mean(axis=0)) <= 0.05 * scale + 1e-3)


@settings(max_examples=examples(20))
@given(poses, poses)
def test_steps_one_after_the_other_have_the_covariance_of_samples(first, second):
    one, two = UncertainStep(first, COVARIANCE), UncertainStep(second, 2.0 * COVARIANCE)
    assert_spread(one.then(two), compose(samples(one, 1), samples(two, 2)))


@settings(max_examples=examples(20))
@given(poses)
def test_a_step_back_has_the_covariance_of_samples(measurement):
    step = UncertainStep(measurement, COVARIANCE)
    assert_spread(step.inverted(), inverse(samples(step, 3)))
    np.testing.assert_allclose(step.inverted().inverted().covariance, COVARIANCE, atol=1e-12)
