import numpy as np
import pytest

from ppaas.mapping.graph.consistency import consistent_sets, largest_consistent_set, loop_chi2
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges
from ppaas.planar_poses import compose, relative
from tests.support.world.pose_graphs import walk


def closures_of(graph):
    return graph.edges.take(graph.edges.kinds == EdgeKind.CLOSURE)


@pytest.mark.parametrize("seed", range(3))
def test_false_closures_are_left_out(seed):
    graph, truth, false = walk(400, 150, false=30, seed=seed)
    closures = closures_of(graph)
    chosen = largest_consistent_set(graph, closures)
    apart = np.hypot(*(truth[closures.first] - truth[closures.second])[:, :2].T)
    assert not chosen[apart > 3.0].any()
    assert chosen[: len(chosen) - false].mean() > 0.8


def test_loops_miss_their_start_as_their_covariances_say():
    distances = [loop_chi2(*parts)[0, 1] for parts in map(two_closures, range(150))]
    assert np.mean(distances) == pytest.approx(3.0, abs=0.5)
    assert np.mean(np.array(distances) > 11.34) < 0.04


def two_closures(seed):
    graph, _, _ = walk(80, 1000, seed=seed)
    closures = closures_of(graph)
    return graph, closures.take(np.random.default_rng(seed).choice(len(closures.first), 2, replace=False))


def test_distances_are_symmetric_and_do_not_depend_on_the_direction():
    graph, _, _ = walk(200, 40)
    closures = closures_of(graph)
    distances = loop_chi2(graph, closures)
    assert (distances == distances.T).all() and (np.diag(distances) == 0.0).all()
    backwards = closures.take(np.arange(len(closures.first))[::-1])
    assert loop_chi2(graph, backwards)[::-1, ::-1] == pytest.approx(distances, rel=0.05, abs=0.05)


def test_second_set_holds_the_closures_that_slipped_together():
    graph, _, _ = walk(400, 150)
    closures = closures_of(graph)
    slipped = np.arange(len(closures.first)) % 5 == 0
    moved = np.where(slipped[:, None], closures.measurements + np.array([1.5, 0.0, 0.0]), closures.measurements)
    sets = list(consistent_sets(graph, closures._replace(measurements=moved)))
    assert (np.sum(sets, axis=0) == 1).all()
    assert not sets[0][slipped].any()
    assert [found.sum() for found in sets] == sorted((found.sum() for found in sets), reverse=True)


def test_closures_that_odometry_does_not_connect_agree():
    graph, _, _ = walk(20, 0)
    graph.keep_edges(graph.edges.second != 10)
    ends = np.array([0, 12]), np.array([5, 17])
    closures = Edges(*ends, np.full((2, 3), 9.0), np.tile(np.eye(3), (2, 1, 1)), np.ones(2, np.uint8))
    assert (loop_chi2(graph, closures) == 0.0).all()
    assert largest_consistent_set(graph, closures).all()


def test_no_closures_have_no_set():
    graph, _, _ = walk(20, 0)
    assert largest_consistent_set(graph, closures_of(graph)).shape == (0,)
    assert list(consistent_sets(graph, closures_of(graph))) == []


def test_closures_between_two_walks_agree_if_they_place_them_alike():
    graph, _, _ = walk(20, 0)
    first, offset = graph.poses.copy(), np.array([5.0, 1.0, 0.7])
    graph.keep_edges(graph.edges.second != 10)
    ends = np.array([1, 4, 8]), np.array([11, 14, 18])
    measured = np.zeros((3, 3))
    for k, (i, j) in enumerate(zip(*ends, strict=True)):
        measured[k] = relative(first[i], compose(offset, first[j]))
    measured[2, 0] += 2.0
    information = np.tile(np.diag([2500.0, 2500.0, 4e4]), (3, 1, 1))
    closures = Edges(*ends, measured, information, np.ones(3, np.uint8))
    assert largest_consistent_set(graph, closures).tolist() == [True, True, False]
