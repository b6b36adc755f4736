"""Score of a trajectory by relations: relative poses of the robot that are known to be true.

R. Kümmerle, B. Steder, C. Dornhege, M. Ruhnke, G. Grisetti, C. Stachniss and A. Kleiner: On measuring the accuracy of
SLAM algorithms, Autonomous Robots 27 (2009). The error of a relation is the difference of the relative pose of the
trajectory from the true one, in the frame of the first pose; no global frame is needed.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.planar_poses import relative

NEAR = 0.3
"""Largest difference between the stamps of a relation and a pose [s]; files of relations have few digits."""

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
        Number of relations without a pose near one of their stamps.
    """

    translations: NDArray[np.float64]
    rotations: NDArray[np.float64]
    unmatched: int = 0

    def summary(self) -> dict[str, float | int]:
        """Return the mean, standard deviation and maximum of the errors in m and degrees, and the number of each."""
        degrees = np.degrees(self.rotations)
        return {
            "relations": len(self.translations),
            "unmatched": self.unmatched,
            "mean_m": round(float(self.translations.mean()), 5),
            "std_m": round(float(self.translations.std()), 5),
            "max_m": round(float(self.translations.max()), 4),
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
    rows = list(_rows(text, COLUMNS, "t1 t2 x y z roll pitch yaw"))
    if not rows:
        raise InvalidInput("the file has no relations: each line is 't1 t2 x y z roll pitch yaw'")
    table = np.array(rows, np.float64)
    return Relations(table[:, :2].copy(), table[:, [2, 3, 7]].copy())


def parse_trajectory(text: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Parse lines ``timestamp x y theta`` and return the (n,) stamps [s] and the (n, 3) poses [m, rad].

    Raises
    ------
    InvalidInput
        A line does not have four finite numbers, or there is no pose.
    """
    rows = list(_rows(text, 4, "timestamp x y theta"))
    if not rows:
        raise InvalidInput("the file has no poses: each line is 'timestamp x y theta'")
    table = np.array(rows, np.float64)
    return table[:, 0].copy(), table[:, 1:].copy()


def format_trajectory(stamps: NDArray[np.float64], poses: NDArray[np.float64]) -> str:
    """Return lines ``timestamp x y theta`` of (n,) stamps [s] and (n, 3) poses [m, rad], with six decimals."""
    rows = np.column_stack((stamps, poses)).tolist()
    return "".join("{:.6f} {:.6f} {:.6f} {:.6f}\n".format(*row) for row in rows)


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


def _rows(text: str, columns: int, names: str) -> Iterator[list[float]]:
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            row = []
        if len(row) != columns or not all(map(math.isfinite, row)):
            raise InvalidInput(f"line {number} is not '{names}': {columns} finite numbers")
        yield row


def _nearest(stamps: NDArray[np.float64], wanted: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the index of the stamp that is nearest to each wanted time, and how far off it is [s]."""
    order = np.argsort(stamps, kind="stable")
    ordered = stamps[order]
    after = np.searchsorted(ordered, wanted)
    after = np.minimum(after, len(ordered) - 1)
    before = np.maximum(after - 1, 0)
    closer = np.where(np.abs(ordered[before] - wanted) <= np.abs(ordered[after] - wanted), before, after)
    return order[closer], np.abs(ordered[closer] - wanted)
