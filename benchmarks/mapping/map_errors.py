"""Errors of maps whose truth is known: of poses, of cells, and closures between places that are apart."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.mapping.simulated_drive import Segments
from ppaas.mapping.graph.pose_graph import EdgeKind
from ppaas.mapping.graph.robust_weights import TRUSTED
from ppaas.mapping.pipeline.graph_mapper import GraphMapper
from ppaas.mapping.pipeline.offline import LogMap
from ppaas.mapping.relations import Relations
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from ppaas.planar_poses import PoseArray, compose, inverse, relative, rotated
from robots.demo.scorer import wrong_cells

NEAR, APART = 3.0, 100
"""Largest distance of the two poses of a relation [m], and smallest number of scans between them."""


def random_relations(stamps: NDArray[np.float64], true: NDArray[np.float64], seed: int, most: int = 3000) -> Relations:
    """Return true relations between random pairs of poses that are near each other, but not in time.

    Parameters
    ----------
    stamps : (n,) array
        Distinct times of the poses [s].
    true : (n, 3) array
        True poses: x, y [m], theta [rad].
    seed : int
        Seed of the choice.
    most : int
        Largest number of relations.
    """
    random = np.random.default_rng(seed)
    pairs = random.integers(0, len(true), (100 * most, 2))
    first, second = pairs.T
    gap = np.hypot(*(true[first, :2] - true[second, :2]).T)
    pairs = pairs[(gap < NEAR) & (np.abs(first - second) > APART)][:most]
    return Relations(stamps[pairs], relative(true[pairs[:, 0]], true[pairs[:, 1]]))


def absolute_errors(true: NDArray[np.float64], estimated: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distances (n,) of the positions [m], after the rotation and shift that fit best (Kabsch 1976)."""
    a, b = (poses[:, :2] - poses[:, :2].mean(axis=0) for poses in (true, estimated))
    left, _, right = np.linalg.svd(b.T @ a)
    rotation = left @ np.diag((1.0, np.sign(np.linalg.det(left @ right)))) @ right
    errors: NDArray[np.float64] = np.hypot(*(b @ rotation - a).T)
    return errors


# -- cells of a map that are wrong, by the walls of the simulated world ------------------------------------------------


def wrong_share(made: LogMap, walls: Segments, true: PoseArray) -> float:
    """Return the part of the known cells that are wrong; the edge of a wall may be off by one cell.

    Parameters
    ----------
    made : LogMap
    walls : (n, 4) array
        In the frame of the true poses.
    true : (n, 3) array
        True poses of the robot: the map is laid on the walls where its first pose is the true one.
    """
    grid = made.grid()
    origin = compose(true[0], relative(made.poses[0], np.zeros(3)))
    ends = walls.reshape(-1, 2)
    in_map = relative(origin, np.column_stack((ends, np.zeros(len(ends)))))[:, :2].reshape(-1, 4)
    wrong, known = wrong_cells(grid, GridMap(_drawn(in_map, grid.info), grid.info))
    return wrong / max(known, 1)


def _drawn(walls: Segments, info: GridInfo) -> NDArray[np.int8]:
    """Return cells that are occupied where a wall is, and free elsewhere."""
    cells = np.full((info.height, info.width), FREE, np.int8)
    for x0, y0, x1, y1 in walls.tolist():
        count = 2 + int(4.0 * np.hypot(x1 - x0, y1 - y0) / info.resolution)
        points = np.column_stack((np.linspace(x0, x1, count), np.linspace(y0, y1, count)))
        at = info.to_cells(points)
        at = at[((at >= 0) & (at < (info.height, info.width))).all(axis=1)]
        cells[at[:, 0], at[:, 1]] = OCCUPIED
    return cells


# -- false closures ----------------------------------------------------------------------------------------------------

OFF = 0.5
"""Error above which a closure is false [m]."""

LEAST_PART = 0.01
"""Least part of the information of the best direction that a direction has of which an edge says something."""

NEAR_PLACE = 1.0
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
        Estimated poses of the robot at the scans: they carry a relation to the ends of a closure, at most `NEAR_PLACE`.
    """
    order = np.argsort(stamps, kind="stable")
    ends = order[np.searchsorted(stamps[order], relations.stamps).clip(max=len(stamps) - 1)]
    both = np.concatenate((ends, ends[:, ::-1]))
    true = np.concatenate((relations.poses, inverse(relations.poses)))
    judged, expected = [], []
    for edge, (first, second) in enumerate(closures.scans):
        away = [np.hypot(*(poses[both[:, side], :2] - poses[scan, :2]).T) for side, scan in ((0, first), (1, second))]
        apart = [np.abs(both[:, side] - scan) for side, scan in ((0, first), (1, second))]
        near = (np.maximum(*away) < NEAR_PLACE) & (np.maximum(*apart) < SOON)
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
