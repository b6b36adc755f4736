"""Score of a trajectory by relations, relative poses of the robot that are known to be true, or by a true trajectory.

R. Kümmerle, B. Steder, C. Dornhege, M. Ruhnke, G. Grisetti, C. Stachniss and A. Kleiner: On measuring the accuracy of
SLAM algorithms, Autonomous Robots 27 (2009). The error of a relation is the difference of the relative pose of the
trajectory from the true one, in the frame of the first pose; no global frame is needed.

A true trajectory may be in another frame: both are aligned first, by the motion with the least squared distances of
their positions (S. Umeyama, PAMI 13, 1991, without a scale).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.mapping.trajectories import PlanarTrajectory, number_rows
from ppaas.planar_poses import compose, differences, relative

NEAR = 0.3
"""Largest difference between the stamps of a relation and a pose [s]; files of relations have few digits."""

AT_ONCE = 0.02
"""Largest difference between the stamps of a pose and of a true pose [s]."""

COLUMNS = 8
"""Numbers of a line: two stamps, x, y, z, roll, pitch, yaw."""


class Relations(NamedTuple):
    """True relative poses.

    Parameters
    ----------
    stamps : (m, 2) float64 array
        Stamps of the two poses of each relation [s].
    poses : (m, 3) float64 array
        Second pose in the frame of the first: x, y [m], theta [rad].
    """

    stamps: NDArray[np.float64]
    poses: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Score:
    """Errors of a trajectory.

    Parameters
    ----------
    translations : (m,) float64 array
        Translational error of each relation that could be compared [m].
    rotations : (m,) float64 array
        Rotational error [rad].
    unmatched : int
        Number of relations without a pose near one of their stamps, or of true poses without one.
    of : str
        What is compared: ``relations``, or ``poses``.
    """

    translations: NDArray[np.float64]
    rotations: NDArray[np.float64]
    unmatched: int = 0
    of: str = "relations"

    def summary(self) -> dict[str, float | int]:
        """Return the mean, standard deviation and maximum of the errors in m and degrees, and the number of each."""
        degrees = np.degrees(self.rotations)
        return {
            self.of: len(self.translations),
            "unmatched": self.unmatched,
            "mean_m": round(float(self.translations.mean()), 5),
            "std_m": round(float(self.translations.std()), 5),
            "max_m": round(float(self.translations.max()), 4),
            "rmse_m": round(float(np.sqrt((self.translations**2).mean())), 5),
            "mean_deg": round(float(degrees.mean()), 4),
            "std_deg": round(float(degrees.std()), 4),
            "max_deg": round(float(degrees.max()), 3),
        }


def parse_relations(text: str) -> Relations:
    """Parse lines ``t1 t2 x y z roll pitch yaw``, in seconds, metres and radians; lines with ``#`` are comments.

    Raises
    ------
    InvalidInput
        A line does not have eight finite numbers, or there is no relation.
    """
    table = number_rows(text, {COLUMNS: "t1 t2 x y z roll pitch yaw"})
    return Relations(table[:, :2].copy(), table[:, [2, 3, 7]].copy())


def score(relations: Relations, stamps: NDArray[np.float64], poses: NDArray[np.float64]) -> Score:
    """Return the errors of a trajectory, whose poses are matched with the relations by the nearest stamp.

    Parameters
    ----------
    relations : Relations
    stamps : (n,) array
        Times of the poses [s], in any order.
    poses : (n, 3) array
        Poses of the robot in one frame: x, y [m], theta [rad].

    Raises
    ------
    InvalidInput
        No relation has poses near both of its stamps.
    """
    nearest, gap = _nearest(stamps, relations.stamps)
    matched = (gap <= NEAR).all(axis=1)
    if not matched.any():
        first, last = float(stamps.min()), float(stamps.max())
        raise InvalidInput(
            f"no relation has poses of the trajectory within {NEAR} s of its stamps; the trajectory is from "
            f"{first:.2f} to {last:.2f} s: are the relations those of this log?"
        )
    pairs = nearest[matched]
    found = relative(poses[pairs[:, 0]], poses[pairs[:, 1]])
    error = relative(relations.poses[matched], found)
    translations = np.hypot(error[:, 0], error[:, 1])
    return Score(translations, np.abs(error[:, 2]), int((~matched).sum()))


def score_by_truth(truth: PlanarTrajectory, found: PlanarTrajectory) -> Score:
    """Return the errors of a trajectory, after it is aligned with the true one.

    Poses are compared by their stamps, or in their order where neither trajectory has stamps.

    Parameters
    ----------
    truth, found : PlanarTrajectory

    Raises
    ------
    InvalidInput
        Fewer than two poses have a true pose at their time; or one of the trajectories has no stamps, or another number
        of poses.
    """
    pairs = _pairs(truth, found)
    if len(pairs) < 2:
        raise InvalidInput(
            f"{len(pairs)} poses have a true pose within {AT_ONCE} s of their stamps: are both of the same drive, and "
            "of one clock?"
        )
    true, poses = truth.poses[pairs[:, 0]], found.poses[pairs[:, 1]]
    errors = differences(compose(_motion_to(true, poses), poses), true)
    return Score(np.hypot(errors[:, 0], errors[:, 1]), np.abs(errors[:, 2]), len(truth.poses) - len(pairs), "poses")


def _pairs(truth: PlanarTrajectory, found: PlanarTrajectory) -> NDArray[np.int64]:
    """Return the indices of true poses and of the poses at their times."""
    if truth.stamps is None and found.stamps is None and len(truth.poses) == len(found.poses):
        return np.repeat(np.arange(len(truth.poses))[:, np.newaxis], 2, axis=1)
    if truth.stamps is None or found.stamps is None:
        raise InvalidInput(
            f"a trajectory of KITTI has no stamps: it is compared with another one of KITTI, pose by pose, and the two "
            f"have {len(truth.poses)} and {len(found.poses)} poses"
        )
    nearest, gap = _nearest(found.stamps, truth.stamps)
    matched = np.flatnonzero(gap <= AT_ONCE)
    _, once = np.unique(nearest[matched], return_index=True)
    return np.column_stack((matched[once], nearest[matched[once]]))


def _motion_to(true: NDArray[np.float64], poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the motion, x, y, theta, that brings positions nearest to true ones."""
    middle, true_middle = poses[:, :2].mean(axis=0), true[:, :2].mean(axis=0)
    a, b = poses[:, :2] - middle, true[:, :2] - true_middle
    turn = float(np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum()))
    c, s = np.cos(turn), np.sin(turn)
    x, y = true_middle - (c * middle[0] - s * middle[1], s * middle[0] + c * middle[1])
    return np.array((x, y, turn))


def _nearest(stamps: NDArray[np.float64], wanted: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the index of the stamp that is nearest to each wanted time, and how far off it is [s]."""
    order = np.argsort(stamps, kind="stable")
    ordered = stamps[order]
    after = np.searchsorted(ordered, wanted)
    after = np.minimum(after, len(ordered) - 1)
    before = np.maximum(after - 1, 0)
    closer = np.where(np.abs(ordered[before] - wanted) <= np.abs(ordered[after] - wanted), before, after)
    return order[closer], np.abs(ordered[closer] - wanted)
