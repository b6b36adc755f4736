"""False closures: edges of a pose graph between places that are not where the edge says."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.pose_graph import EdgeKind
from ppaas.mapping.graph.robust_weights import TRUSTED
from ppaas.mapping.pipeline.graph_mapper import GraphMapper
from ppaas.mapping.relations import Relations
from ppaas.planar_poses import PoseArray, compose, inverse, relative, rotated

OFF = 0.5
"""Error above which a closure is false [m]."""

LEAST_PART = 0.01
"""Least part of the information of the best direction that a direction has of which an edge says something."""

NEAR = 1.0
"""Largest distance between the ends of a closure and those of a relation that judges it [m]."""

SOON = 100
"""Largest number of scans between the ends of a closure and those of a relation that judges it."""


class FalseClosures(NamedTuple):
    """Numbers of edges of closures that the map is made of: all, those whose truth is known, and false ones."""

    edges: int
    judged: int
    false: int


class Closures(NamedTuple):
    """Edges of closures that count in a map.

    Parameters
    ----------
    scans : (m, 2) array
        Scans at their ends.
    motions : (m, 3) array
        Pose of the robot at the second scan in the frame of the first: x, y [m], theta [rad].
    information : (m, 2, 2) array
        Information of the position, in the frame of the robot at the first scan.
    """

    scans: NDArray[np.int64]
    motions: PoseArray
    information: NDArray[np.float64]


def surviving(mapper: GraphMapper) -> Closures:
    """Return the edges of closures that the solver trusts."""
    edges, frames = mapper.graph.edges, mapper.key_frames
    kept = (edges.kinds == EdgeKind.CLOSURE) & (mapper.weights >= TRUSTED)
    mount = np.array(frames.geometry.mount)
    ends = np.stack((edges.first[kept], edges.second[kept]), axis=1)
    motions = compose(compose(mount, edges.measurements[kept]), inverse(mount))
    return Closures(frames.scans[ends], motions, rotated(edges.information[kept], mount[2])[:, :2, :2])


def by_poses(closures: Closures, true: PoseArray) -> FalseClosures:
    """Judge closures by the true poses (n, 3) of the robot at all scans."""
    expected = relative(true[closures.scans[:, 0]], true[closures.scans[:, 1]])
    count = len(expected)
    return FalseClosures(count, count, int(_off(closures, np.arange(count), expected).sum()))


def by_relations(
    closures: Closures, relations: Relations, stamps: NDArray[np.float64], poses: PoseArray
) -> FalseClosures:
    """Judge closures by true relations between scans near their ends.

    Parameters
    ----------
    closures : Closures
    relations : Relations
    stamps : (n,) array
        Times of the scans [s].
    poses : (n, 3) array
        Estimated poses of the robot at the scans: they carry a relation to the ends of a closure, at most `NEAR`.
    """
    order = np.argsort(stamps, kind="stable")
    ends = order[np.searchsorted(stamps[order], relations.stamps).clip(max=len(stamps) - 1)]
    both = np.concatenate((ends, ends[:, ::-1]))
    true = np.concatenate((relations.poses, inverse(relations.poses)))
    judged, expected = [], []
    for edge, (first, second) in enumerate(closures.scans):
        away = [np.hypot(*(poses[both[:, side], :2] - poses[scan, :2]).T) for side, scan in ((0, first), (1, second))]
        apart = [np.abs(both[:, side] - scan) for side, scan in ((0, first), (1, second))]
        near = (np.maximum(*away) < NEAR) & (np.maximum(*apart) < SOON)
        if not near.any():
            continue
        best = int(np.argmin(np.where(near, away[0] + away[1], np.inf)))
        carried = compose(relative(poses[first], poses[both[best, 0]]), true[best])
        judged.append(edge)
        expected.append(compose(carried, relative(poses[both[best, 1]], poses[second])))
    false = _off(closures, np.array(judged, np.int64), np.array(expected).reshape(-1, 3))
    return FalseClosures(len(closures.scans), len(judged), int(false.sum()))


def _off(closures: Closures, judged: NDArray[np.int64], expected: PoseArray) -> NDArray[np.bool_]:
    """Return whether edges are far from the expected motions, in the directions in which they say something.

    An edge along a bare corridor gives the distance from the walls only.
    """
    values, axes = np.linalg.eigh(closures.information[judged])
    errors = np.einsum("mij,mi->mj", axes, (closures.motions[judged] - expected)[:, :2])
    errors[values < LEAST_PART * values[:, 1:]] = 0.0
    off: NDArray[np.bool_] = np.hypot(errors[:, 0], errors[:, 1]) > OFF
    return off
