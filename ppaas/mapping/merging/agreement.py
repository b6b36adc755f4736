"""Agreement of matches: sets in which every two are explained by the drift along both mappings between them."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.closures.drift import path_covariances
from ppaas.mapping.closures.parameters import DriftModel
from ppaas.mapping.graph.consistency import CHI2
from ppaas.mapping.graph.largest_clique import largest_clique
from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.merging.matches import PlaceMatch
from ppaas.planar_poses import compose, relative, rotated

FLOOR = (0.15, 0.15, 0.03)
"""Standard deviations of the difference of two matches without any drift [m, m, rad]."""


def agreeing_sets(graph: PoseGraph, matches: Sequence[PlaceMatch], drift: DriftModel) -> Iterator[list[PlaceMatch]]:
    """Yield disjoint sets of matches that agree pairwise: the largest, the largest of the others, and so on.

    Parameters
    ----------
    graph : PoseGraph
        Nodes and edges of both mappings, each in its own frame; no edge connects them.
    matches : sequence of PlaceMatch
    drift : DriftModel
        Growth of the uncertainty with the distance travelled.
    """
    agree = pairwise_chi2(graph, matches, drift) <= CHI2
    remaining = np.arange(len(matches))
    while remaining.size:
        chosen = remaining[largest_clique(agree[np.ix_(remaining, remaining)])]
        yield [matches[k] for k in chosen]
        remaining = np.setdiff1d(remaining, chosen)


def pairwise_chi2(graph: PoseGraph, matches: Sequence[PlaceMatch], drift: DriftModel) -> NDArray[np.float64]:
    """Return the squared Mahalanobis distances (m, m) of every two matches.

    Two matches place one key frame differently. The covariance of that difference is the covariance of the paths
    between the matches, along the one mapping and along the other. Two matches of one part of the drive at different
    places thus never agree. Parameters are the same as for `agreeing_sets`.
    """
    count = len(matches)
    sources = np.array([_middle(match.edges.second) for match in matches], np.int64)
    targets = np.array([_middle(match.edges.first) for match in matches], np.int64)
    motions = np.array([tuple(match.motion) for match in matches]).reshape(count, 3)
    distances = np.zeros((count, count))
    for k in range(count):
        along_second, _ = path_covariances(graph.poses, graph.edges, int(sources[k]), drift)
        along_first, _ = path_covariances(graph.poses, graph.edges, int(targets[k]), drift)
        placed = compose(motions, graph.poses[sources[k]])
        apart = placed - placed[k]
        apart[:, 2] = relative(placed[k], placed)[:, 2]
        total = along_first[targets] + rotated(along_second[sources], motions[:, 2]) + np.diag(np.square(FLOOR))
        distances[k] = _squared(apart, total)
    return np.maximum(distances, distances.T)


def _squared(errors: NDArray[np.float64], covariances: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return squared Mahalanobis distances (m,); 0 where no path gives a covariance."""
    known = np.isfinite(covariances).all(axis=(1, 2))
    found = np.zeros(len(errors))
    solved = np.linalg.solve(covariances[known], errors[known][:, :, None])[:, :, 0]
    found[known] = np.einsum("mi,mi->m", errors[known], solved)
    return found


def _middle(nodes: NDArray[np.int64]) -> int:
    return int(nodes[len(nodes) // 2])
