"""Pose graphs of a walk on a grid of streets, with measurements that have noise, and with false closures."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.planar_poses import PoseArray, compose, relative

Ends = NDArray[np.int64]
"""Nodes at the two ends of edges, (m, 2)."""

STEP = 0.5
"""Distance between two nodes [m]."""

ODOMETRY_NOISE, CLOSURE_NOISE = (0.02, 0.02, 0.005), (0.02, 0.02, 0.005)
"""Standard deviations of a measurement [m, m, rad]."""


class Walk(NamedTuple):
    """A graph whose nodes are where odometry puts them, the true poses, and the number of false edges at its end."""

    graph: PoseGraph
    truth: PoseArray
    false: int


def walk(nodes: int, closures: int, false: int = 0, seed: int = 0) -> Walk:
    """Return the graph of a walk.

    Parameters
    ----------
    nodes, closures, false : int
        Number of nodes, of true closures (fewer if the walk meets itself less often), and of false ones.
    seed : int
    """
    random = np.random.default_rng(seed)
    truth = _streets(nodes, random)
    near = np.sort(cKDTree(truth[:, :2]).query_pairs(1.2 * STEP, output_type="ndarray"), axis=1)
    near = near[near[:, 1] - near[:, 0] > 5]
    near = near[random.permutation(len(near))[:closures]]
    ends = np.array([random.choice(nodes, 2, replace=False) for _ in range(false)], np.int64).reshape(-1, 2)
    chain = np.column_stack((np.arange(nodes - 1), np.arange(1, nodes)))
    graph = PoseGraph()
    odometry = _measured(truth, chain, ODOMETRY_NOISE, random)
    pose = np.zeros(3)
    graph.add_node(pose)
    for step in odometry:
        pose = compose(pose, step)
        graph.add_node(pose)
    _add(graph, chain, odometry, ODOMETRY_NOISE, EdgeKind.ODOMETRY)
    _add(graph, near, _measured(truth, near, CLOSURE_NOISE, random), CLOSURE_NOISE, EdgeKind.CLOSURE)
    _add(graph, ends, random.normal(0.0, (0.5, 0.5, 0.3), (false, 3)), CLOSURE_NOISE, EdgeKind.CLOSURE)
    return Walk(graph, truth, false)


def _streets(nodes: int, random: np.random.Generator) -> PoseArray:
    """Return poses on a grid of streets, which leave it at no side."""
    size, heading, poses = max(4, int(0.35 * nodes**0.5)) * STEP, 0, np.zeros((nodes, 3))
    for i in range(1, nodes):
        if i % 8 == 0 and random.random() < 0.5:
            heading += random.choice([1, 3])
        ahead = poses[i - 1, :2] + _ahead(heading)
        if (np.abs(ahead) > size).any():
            heading += 2
            ahead = poses[i - 1, :2] + _ahead(heading)
        poses[i] = *ahead, heading % 4 * np.pi / 2
    poses[1:] += random.normal(0.0, (0.05, 0.05, 0.1), (nodes - 1, 3))
    return poses


def _ahead(heading: int) -> PoseArray:
    return STEP * np.array([(1, 0), (0, 1), (-1, 0), (0, -1)][heading % 4])


def _measured(truth: PoseArray, ends: Ends, noise: tuple[float, ...], random: np.random.Generator) -> PoseArray:
    return relative(truth[ends[:, 0]], truth[ends[:, 1]]) + random.normal(0.0, noise, (len(ends), 3))


def _add(graph: PoseGraph, ends: Ends, measured: PoseArray, noise: tuple[float, ...], kind: EdgeKind) -> None:
    information = np.diag(1.0 / np.square(noise))
    for (first, second), measurement in zip(ends.tolist(), measured, strict=True):
        graph.add_edge(first, second, measurement, information, kind)
