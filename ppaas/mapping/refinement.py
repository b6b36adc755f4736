"""Joint refinement of key frames: distances from points to lines of all overlapping pairs are minimized at once.

As bundle adjustment: the pairs of points are found at the current poses, their normal equations are summed up per pair
of key frames, and one sparse system gives the step of all poses.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.normal_equations import JointSystem, LinearisedPairs
from ppaas.mapping.graph.pose_graph import Edges
from ppaas.mapping.kernels import alignment as kernels
from ppaas.mapping.key_frame_graph import forgetting, weakest_information
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.near_poses import nearest_poses
from ppaas.planar_poses import PoseArray, differences, relative, rotated, symmetric, upper_triangle, wrap_angles

DAMPING = 1e-3
"""Information added to each pose in a step [1/m², 1/rad²]."""

CHUNK = 8192
"""Number of pairs of key frames that are linearised at once, which bounds the memory of all that is calculated."""

LEAST_PART = 0.01
"""Least part of the information of the best direction that a direction of the position must have."""


class RefinementSettings(NamedTuple):
    """Settings of a refinement.

    Parameters
    ----------
    gates : tuple of float
        Largest distance of two points of a pair in each iteration [m].
    pair_again : tuple of int
        Iterations at whose start the overlapping pairs of key frames are found.
    radius : float
        Largest distance of two key frames of a pair; see `nearest_poses` [m].
    near : int
        Number of nearest key frames that each one is paired with.
    following : int
        Number of key frames before and after that each one is paired with.
    least_ratio : float
        Least part of the points that have a pair.
    scale : float
        Distance at which the weight is a quarter [m]; it grows with gates above 0.15 m.
    deviation : float
        Standard deviation of a distance [m].
    evidence : float
        Part of the points that count as independent.
    beams : int
        See `ppaas.mapping.alignment.AlignmentSettings`.
    step : float
        Largest step of a coordinate below which the refinement has converged [m, rad].
    """

    gates: tuple[float, ...] = (0.3, 0.2, 0.15, 0.1)
    pair_again: tuple[int, ...] = (0, 2)
    radius: float = 4.0
    near: int = 24
    following: int = 3
    least_ratio: float = 0.3
    scale: float = 0.03
    deviation: float = 0.02
    evidence: float = 0.1
    beams: int = 8
    step: float = 2e-4


DEFAULTS = RefinementSettings()


class Refined(NamedTuple):
    """Result of a refinement.

    Parameters
    ----------
    poses : (k, 3) float64 array
        Poses of the key frames; the first one has not moved.
    pairs : int
        Number of pairs of key frames that overlap.
    iterations : int
        Number of steps.
    distance : float
        Weighted root mean square of the distances of the points from the lines, before the last step [m].
    """

    poses: PoseArray
    pairs: int
    iterations: int
    distance: float


def refine(
    key_frames: KeyFrames,
    poses: PoseArray,
    odometry: Edges,
    settings: RefinementSettings = DEFAULTS,
    cancelled: Callable[[], bool] = lambda: False,
) -> Refined:
    """Return poses of the key frames at which all overlapping scans fit best.

    Parameters
    ----------
    key_frames : KeyFrames
        Scans of the map.
    poses : (k, 3) array
        Their poses, with all closures applied: errors larger than the first gate are not repaired.
    odometry : Edges
        Edges of the graph to keep, weighted by their information: odometry edges, not closures.
    settings : RefinementSettings
        Gates, weights and pairs.
    cancelled : callable
        Returns whether the result is no longer needed: no further step is made then.

    Raises
    ------
    InvalidGraph
        The normal equations are not positive definite.
    """
    work = _Refinement(key_frames, odometry, settings, cancelled)
    moved, count = poses.copy(), 0
    # One key frame has nothing to be aligned with.
    if len(poses) < 2:
        return Refined(moved, 0, 0, 0.0)
    with suppress(_Cancelled):
        for step in work.steps(moved):
            moved += step
            count += 1
    moved[:, 2] = wrap_angles(moved[:, 2])
    return Refined(moved, work.used, count, work.distance)


class _Cancelled(Exception):
    """The result of a refinement is no longer needed."""


class _Refinement:
    """Pairs of key frames, and the steps that they give."""

    def __init__(
        self, key_frames: KeyFrames, odometry: Edges, settings: RefinementSettings, cancelled: Callable[[], bool]
    ) -> None:
        self._frames, self._odometry, self._settings, self._cancelled = key_frames, odometry, settings, cancelled
        self._system = JointSystem()
        self._first = self._second = np.empty(0, np.int64)
        self.used, self.distance = 0, 0.0

    def steps(self, poses: PoseArray) -> Iterator[PoseArray]:
        """Yield changes of poses, which the caller adds to them, until these are small."""
        for count, gate in enumerate(self._settings.gates):
            # Not before each step: finding pairs linearises all of them, which costs as much as a step.
            if count in self._settings.pair_again:
                self.find_pairs(poses)
            step = self.step(poses, gate)
            yield step
            if np.abs(step).max() < self._settings.step:
                return

    def find_pairs(self, poses: PoseArray) -> None:
        """Choose the pairs of key frames: nearest ones, and those that follow each other, if their scans overlap."""
        self._first, self._second = _pairs_of(poses, self._settings)
        parts = self._linearised(poses, self._settings.gates[0])
        overlap = np.concatenate([self._overlap(counts) for _, _, counts, _ in parts])
        self._first, self._second = self._first[overlap], self._second[overlap]

    def step(self, poses: PoseArray, gate: float) -> PoseArray:
        """Return the changes of all poses."""
        settings, pairs, odometry = self._settings, len(self._first), self._odometry
        hessians, gradients = np.empty((pairs + len(odometry.first), 3, 3)), np.empty((pairs + len(odometry.first), 3))
        used = points = 0
        squared = 0.0
        for chunk, sums, counts, squares in self._linearised(poses, gate):
            # Pairs that do not overlap any more stay in the system with weight 0, so that its pattern stays the same.
            overlap = self._overlap(counts)
            weighted = sums * (overlap * settings.evidence / settings.deviation**2)[:, np.newaxis]
            _forget_undetermined(weighted)
            turns = poses[self._second[chunk], 2] - poses[self._first[chunk], 2]
            hessians[chunk], gradients[chunk] = _turned(weighted, turns)
            used, points = used + int(overlap.sum()), points + int(counts[overlap, 0].sum())
            squared += float(squares[overlap].sum())
        self.used, self.distance = used, float(np.sqrt(squared / max(points, 1)))
        errors = differences(relative(poses[odometry.first], poses[odometry.second]), odometry.measurements)
        hessians[pairs:] = odometry.information
        gradients[pairs:] = np.einsum("mij,mj->mi", odometry.information, errors)
        first, second = np.concatenate((self._first, odometry.first)), np.concatenate((self._second, odometry.second))
        return self._system.step(poses, LinearisedPairs(first, second, hessians, gradients), DAMPING)

    def _linearised(
        self, poses: PoseArray, gate: float
    ) -> Iterator[tuple[slice, NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]]:
        """Yield the normal equations of the pairs in chunks, see `ppaas.mapping.kernels.alignment.linearise`."""
        frames, settings = self._frames, self._settings
        geometry = frames.geometry
        for begin in range(0, len(self._first), CHUNK):
            if self._cancelled():
                raise _Cancelled
            chunk = slice(begin, min(begin + CHUNK, len(self._first)))
            first, second = self._first[chunk], self._second[chunk]
            sums, counts, squares = kernels.linearise(
                first, second, relative(poses[first], poses[second]), frames.points, frames.normals, frames.valid,
                geometry.angle_min, geometry.beams_per_radian, geometry.beams_per_turn,
                gate, settings.scale * max(1.0, gate / kernels.WIDE_GATE), settings.beams,
            )  # fmt: skip
            yield chunk, sums, counts, squares

    def _overlap(self, counts: NDArray[np.int64]) -> NDArray[np.bool_]:
        overlap: NDArray[np.bool_] = counts[:, 0] >= self._settings.least_ratio * np.maximum(counts[:, 1], 1)
        return overlap


def _pairs_of(poses: PoseArray, settings: RefinementSettings) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return ordered pairs of different key frames, each once."""
    count = len(poses)
    near = nearest_poses(poses, poses, settings.near + 1, settings.radius)
    first, second = np.repeat(np.arange(count), near.shape[1]), near.ravel()
    keys = [(first * count + second)[(second >= 0) & (second != first)]]
    for k in range(1, min(settings.following, count - 1) + 1):
        before, after = np.arange(count - k), np.arange(k, count)
        keys += [before * count + after, after * count + before]
    found = np.unique(np.concatenate(keys))
    return found // count, found % count


def _turned(sums: NDArray[np.float64], turns: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return normal equations (m, 9) in other frames, turned by (m,) angles: Hessians (m, 3, 3), gradients (m, 3)."""
    c, s = np.cos(turns), np.sin(turns)
    gradients = np.stack((c * sums[:, 6] - s * sums[:, 7], s * sums[:, 6] + c * sums[:, 7], sums[:, 8]), axis=-1)
    return rotated(symmetric(sums[:, :6]), turns), gradients


def _forget_undetermined(sums: NDArray[np.float64]) -> None:
    """Remove the direction in which scans hardly determine the position from normal equations; see `forgetting`.

    Over many pairs, the information along a corridor would outweigh the odometry.

    Parameters
    ----------
    sums : (m, 9) array
        Modified: see `ppaas.mapping.kernels.alignment`.
    """
    weakest, trace = weakest_information(sums[:, :6]), sums[:, 0] + sums[:, 3]
    weak = weakest < LEAST_PART * (trace - weakest)
    kept = np.tile(np.eye(3), (len(sums), 1, 1))
    kept[weak] = forgetting(sums[weak, :6])
    sums[:, :6] = upper_triangle(kept @ symmetric(sums[:, :6]) @ kept)
    sums[:, 6:] = np.einsum("mij,mj->mi", kept, sums[:, 6:])
