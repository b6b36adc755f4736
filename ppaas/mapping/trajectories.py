"""Trajectories as text: of the robot in the plane, of the TUM RGB-D benchmark, and of the KITTI benchmark.

Sources: https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats (``timestamp tx ty tz qx qy qz qw``) and the
development kit of KITTI's odometry benchmark (the upper three rows of a 4 × 4 matrix, row by row, without times).
"""

import math
from collections.abc import Mapping
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.planar_poses import wrap_angles

TrajectoryFormat = Literal["planar", "tum", "kitti"]
TRAJECTORY_FORMATS: tuple[TrajectoryFormat, ...] = get_args(TrajectoryFormat)

PLANAR, TUM, KITTI = 4, 8, 12
"""Numbers in a line of each format."""

LINES = {
    PLANAR: "timestamp x y theta",
    TUM: "timestamp tx ty tz qx qy qz qw (TUM)",
    KITTI: "the 12 numbers of a 3 × 4 matrix (KITTI)",
}
"""What a line has, by the number of its numbers."""

MOST_TILT = math.radians(15.0)
"""Largest angle between the z axis of a pose and that of the frame, above which it is no pose of a robot [rad]."""

ROUNDED = 0.01
"""Amount by which the length of a quaternion, or the rows of a rotation, may differ from 1 by rounding."""


class PlanarTrajectory(NamedTuple):
    """Poses of a robot in the plane.

    Parameters
    ----------
    stamps : (n,) float64 array or None
        Times of the poses [s]; None if the format has none.
    poses : (n, 3) float64 array
        x, y [m], theta [rad].
    """

    stamps: NDArray[np.float64] | None
    poses: NDArray[np.float64]


def parse_trajectory(text: str) -> PlanarTrajectory:
    """Parse a trajectory in the format that the number of numbers in its lines shows.

    Of poses in space, height, roll and pitch are left out.

    Raises
    ------
    InvalidInput
        A line is of another format, a number is not finite, a rotation is none, a pose is tilted by more than 15°, or
        there is no pose.
    """
    table = number_rows(text, LINES)
    columns = table.shape[1]
    if columns == PLANAR:
        return PlanarTrajectory(table[:, 0].copy(), table[:, 1:].copy())
    if columns == TUM:
        x, y, z, w = _unit_quaternions(table[:, 4:]).T
        up = 1.0 - 2.0 * (x * x + y * y)
        heading = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        stamps, places = table[:, 0].copy(), table[:, 1:3]
    else:
        matrices = _rotations(table.reshape(-1, 3, 4)[:, :, :3])
        up, heading = matrices[:, 2, 2], np.arctan2(matrices[:, 1, 0], matrices[:, 0, 0])
        stamps, places = None, table[:, [3, 7]]
    _check_level(up)
    return PlanarTrajectory(stamps, np.column_stack((places, wrap_angles(heading))))


def is_trajectory(text: str) -> bool:
    """Return whether lines of numbers are a trajectory, and not relations ``t1 t2 x y z roll pitch yaw``.

    A file of TUM has as many numbers in a line as relations. The last four of each line are a quaternion of length 1.
    """
    try:
        table = number_rows(text, LINES)
    except InvalidInput:
        return False
    return table.shape[1] != TUM or bool((np.abs(np.linalg.norm(table[:, 4:], axis=1) - 1.0) < ROUNDED).all())


def format_trajectory(
    stamps: NDArray[np.float64], poses: NDArray[np.float64], form: TrajectoryFormat = "planar"
) -> str:
    """Return the lines of a trajectory, with six decimals, and nine where rotations are.

    Parameters
    ----------
    stamps : (n,) float64 array
        Times of the poses [s], in any order. Programs that read TUM's format need ascending ones, so that it has them
        in this order; of poses of one time, it has the first.
    poses : (n, 3) float64 array
        x, y [m], theta [rad].
    form : {"planar", "tum", "kitti"}
        Format.
    """
    x, y, theta = poses.T
    zero, one = np.zeros(len(poses)), np.ones(len(poses))
    if form == "planar":
        return _lines("{:.6f} {:.6f} {:.6f} {:.6f}\n", np.column_stack((stamps, poses)))
    if form == "tum":
        rows = np.column_stack((stamps, x, y, zero, zero, zero, np.sin(0.5 * theta), np.cos(0.5 * theta)))
        _, ascending = np.unique(np.round(stamps, 6), return_index=True)
        return _lines("{:.6f} {:.6f} {:.6f} {:g} {:g} {:g} {:.9f} {:.9f}\n", rows[ascending])
    c, s = np.cos(theta), np.sin(theta)
    rows = np.column_stack((c, -s, zero, x, s, c, zero, y, zero, zero, one, zero))
    row = "{:.9f} {:.9f} {:g} {:.6f} "
    return _lines(row + row + "{:g} {:g} {:g} {:g}\n", rows)


def _lines(form: str, rows: NDArray[np.float64]) -> str:
    return "".join(form.format(*row) for row in rows.tolist())


def number_rows(text: str, forms: Mapping[int, str]) -> NDArray[np.float64]:
    """Return the numbers of the lines of a text, without those that are empty or comments (``#``).

    Parameters
    ----------
    text : str
    forms : mapping of int to str
        Names of the numbers in a line, by their number. All lines of the text have one of these.

    Returns
    -------
    (n, columns) float64 array

    Raises
    ------
    InvalidInput
        A line does not have as many finite numbers, or there is none; the text names the line.
    """
    lines = text.splitlines()
    rows = [words for line in lines if (words := line.split("#", 1)[0].split())]
    if not rows:
        raise InvalidInput(f"the file has no line of numbers: each is {' or '.join(map(repr, forms.values()))}")
    try:
        table = np.array(rows, np.float64)
    except ValueError as error:  # words that are no numbers, or lines of several lengths
        raise _fault(lines, forms) from error
    if table.shape[1] not in forms or not np.isfinite(table).all():
        raise _fault(lines, forms)
    return table


def _fault(lines: list[str], forms: Mapping[int, str]) -> InvalidInput:
    """Return the error that names the first line that is none of the forms, or of another one than the first."""
    allowed, number = dict(forms), 0
    for at, line in enumerate(lines, 1):
        words = line.split("#", 1)[0].split()
        number = at if words else number
        if words and (len(words) not in allowed or not all(map(_is_finite, words))):
            break
        allowed = {len(words): forms[len(words)]} if words else allowed
    names = " or ".join(f"'{name}'" for name in allowed.values())
    counts = " or ".join(map(str, allowed))
    return InvalidInput(f"line {number} is not {names}: {counts} finite numbers")


def _is_finite(word: str) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False


def _unit_quaternions(quaternions: NDArray[np.float64]) -> NDArray[np.float64]:
    lengths = np.linalg.norm(quaternions, axis=1)
    wrong = np.flatnonzero(np.abs(lengths - 1.0) > ROUNDED)
    if len(wrong):
        raise InvalidInput(
            f"pose {wrong[0] + 1} has a quaternion of length {lengths[wrong[0]]:.3g}: its length must be 1; the order "
            "of TUM is qx qy qz qw"
        )
    unit: NDArray[np.float64] = quaternions / lengths[:, np.newaxis]
    return unit


def _rotations(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    products = matrices @ matrices.transpose(0, 2, 1)
    wrong = np.flatnonzero(np.abs(products - np.eye(3)).max(axis=(1, 2)) > ROUNDED)
    if len(wrong):
        raise InvalidInput(f"pose {wrong[0] + 1} has a matrix that is no rotation: its rows must be orthogonal, of 1")
    return matrices


def _check_level(up: NDArray[np.float64]) -> None:
    tilts = np.arccos(np.clip(up, -1.0, 1.0))
    if tilts.max() > MOST_TILT:
        worst = int(tilts.argmax())
        raise InvalidInput(
            f"pose {worst + 1} is tilted by {math.degrees(tilts[worst]):.0f}°: poses are of a robot in the plane, with "
            "z up; transform those of a camera into the frame of the robot first"
        )
