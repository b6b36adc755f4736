"""Kernels: alignment of a scan with key frames by distances from points to lines.

A scan is (b, 2) float32 points [m], (b, 2) float32 unit normals ((0, 0) = none) and (b,) bool valid, in the frame of
the laser; key frames are stacked scans. Sums of the normal equations are (9,) float64: the upper triangle xx, xy, xt,
yy, yt, tt of the information, then the gradient x, y, t, of a motion of the scan in its own frame.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.mapping.kernels.pose import relative, solve

FACING = 0.7
"""Least cosine between the normals of a pair."""

BETWEEN = 0.7
"""Largest distance of a point along a line from the line's point, in spacings of the points on it."""

WIDE_GATE = 0.15
"""Gate above which the scale of the weights grows with the gate [m]."""

STEP = 1e-4
"""Step below which an alignment has converged [m, rad]."""

SMALL_STEP = 5e-3
"""Step below which an alignment needs no wide gate any more [m, rad]."""


@compiled(fastmath=True, inline="always")
def bearing(x: float, y: float) -> float:
    """Return atan2(y, x) to 0.004 rad, which suffices to find a beam (Rajan et al., 2006, equation 6)."""
    ax, ay = abs(x), abs(y)
    z = min(ax, ay) / (max(ax, ay) + 1e-12)
    angle = z * (0.25 * math.pi + 0.273 * (1.0 - z))
    if ay > ax:
        angle = 0.5 * math.pi - angle
    if x < 0.0:
        angle = math.pi - angle
    return -angle if y < 0.0 else angle


@compiled(fastmath=True)
def associate(
    x: float,
    y: float,
    gate: float,
    angle_min: float,
    per_radian: float,
    turn: int,
    side: int,
    points: NDArray[np.float32],
    normals: NDArray[np.float32],
) -> int:
    """Return the beam of a key frame whose point is nearest to (x, y) and has a normal; −1 if it is beyond the gate.

    Successive points of a wall at a glancing angle lie farther apart than the gate. So for a point between them, only
    the distance from the line has to be within the gate. The points of the line lie r² / (p · beams per radian) apart,
    with the range r and the distance p of the line from the laser.

    Parameters
    ----------
    x, y : float
        Point in the frame of the key frame [m].
    gate : float
        Largest distance [m].
    angle_min : float
        Direction of beam 0 [rad].
    per_radian : float
        Number of beams per radian; negative for a laser that turns clockwise.
    turn : int
        Number of beams of a full turn.
    side : int
        Largest number of beams to each side of the bearing of (x, y) that are examined.
    points, normals : (b, 2) float32 array
        Key frame.
    """
    reach = math.sqrt(x * x + y * y)
    middle = math.floor((bearing(x, y) - angle_min) * per_radian + 0.5)
    half = min(side, int(gate * abs(per_radian) / (reach + 1e-6)) + 1)
    nearest, found = np.inf, -1
    for at in range(middle - half, middle + half + 1):
        # Beams beyond the ends of the sweep may be those of the other end, one turn away.
        k = at + turn if at < 0 else at - turn if at >= turn else at
        if k < 0 or k >= points.shape[0] or (normals[k, 0] == 0.0 and normals[k, 1] == 0.0):
            continue
        dx, dy = x - points[k, 0], y - points[k, 1]
        squared = dx * dx + dy * dy
        if squared < nearest:
            nearest, found = squared, k
    if found >= 0 and nearest > gate * gate:
        # Between two points of a surface that is seen at a glancing angle, the line counts.
        nx, ny = normals[found, 0], normals[found, 1]
        away = nx * (x - points[found, 0]) + ny * (y - points[found, 1])
        plumb = abs(nx * points[found, 0] + ny * points[found, 1])
        along = BETWEEN * reach * reach / (abs(per_radian) * plumb + 1e-6)
        if away * away > gate * gate or nearest > along * along:
            return -1
    return found


@compiled(fastmath=True)
def add_pairs(
    points: NDArray[np.float32],
    normals: NDArray[np.float32],
    valid: NDArray[np.bool_],
    frame_points: NDArray[np.float32],
    frame_normals: NDArray[np.float32],
    pose: NDArray[np.float64],
    angle_min: float,
    per_radian: float,
    turn: int,
    gate: float,
    scale: float,
    side: int,
    sums: NDArray[np.float64],
) -> tuple[int, int, float]:
    """Add the weighted pairs of a scan with one key frame to the normal equations.

    Parameters
    ----------
    points, normals, valid
        Scan.
    frame_points, frame_normals : (b, 2) float32 array
        Key frame.
    pose : (3,) float64 array
        Pose of the scan in the frame of the key frame: x, y [m], theta [rad].
    angle_min, per_radian, turn, gate, side
        See `associate`.
    scale : float
        Distance at which the weight is a quarter [m] (Geman-McClure).
    sums : (9,) float64 array
        Modified: the sums of all pairs with unit variance.

    Returns
    -------
    pairs : int
        Number of pairs.
    readings : int
        Number of points of the scan.
    squares : float
        Weighted sum of the squared distances [m²].
    """
    c, s = math.cos(pose[2]), math.sin(pose[2])
    pairs, readings, squares = 0, 0, 0.0
    xx, xy, xt, yy, yt, tt, gx, gy, gt = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for b in range(points.shape[0]):
        if not valid[b]:
            continue
        readings += 1
        px, py = points[b, 0], points[b, 1]
        x, y = c * px - s * py + pose[0], s * px + c * py + pose[1]
        k = associate(x, y, gate, angle_min, per_radian, turn, side, frame_points, frame_normals)
        if k < 0:
            continue
        # The normal of the key frame's point, turned into the frame of the scan.
        nx = c * frame_normals[k, 0] + s * frame_normals[k, 1]
        ny = c * frame_normals[k, 1] - s * frame_normals[k, 0]
        has_normal = normals[b, 0] != 0.0 or normals[b, 1] != 0.0
        if has_normal and nx * normals[b, 0] + ny * normals[b, 1] < FACING:
            continue
        error = frame_normals[k, 0] * (x - frame_points[k, 0]) + frame_normals[k, 1] * (y - frame_points[k, 1])
        u = error / scale
        root = 1.0 / (1.0 + u * u)
        weight = root * root
        turned = ny * px - nx * py  # derivative of the distance by the heading
        xx, xy, xt = xx + weight * nx * nx, xy + weight * nx * ny, xt + weight * nx * turned
        yy, yt, tt = yy + weight * ny * ny, yt + weight * ny * turned, tt + weight * turned * turned
        weighted = weight * error
        gx, gy, gt = gx + weighted * nx, gy + weighted * ny, gt + weighted * turned
        pairs += 1
        squares += weighted * error
    sums[0], sums[1], sums[2] = sums[0] + xx, sums[1] + xy, sums[2] + xt
    sums[3], sums[4], sums[5] = sums[3] + yy, sums[4] + yt, sums[5] + tt
    sums[6], sums[7], sums[8] = sums[6] + gx, sums[7] + gy, sums[8] + gt
    return pairs, readings, squares


@compiled
def align(
    points: NDArray[np.float32],
    normals: NDArray[np.float32],
    valid: NDArray[np.bool_],
    start: NDArray[np.float64],
    near: NDArray[np.int64],
    poses: NDArray[np.float64],
    frame_points: NDArray[np.float32],
    frame_normals: NDArray[np.float32],
    angle_min: float,
    per_radian: float,
    turn: int,
    gates: NDArray[np.float64],
    scale: float,
    side: int,
    deviation: float,
    expected: NDArray[np.float64],
    precision: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], float, int]:
    """Return the pose of a scan that fits key frames best near a start, by Gauss-Newton.

    Parameters
    ----------
    points, normals, valid
        Scan.
    start : (3,) float64 array
        Pose at the start in the map frame: x, y [m], theta [rad].
    near : (m,) int64 array
        Indices of the key frames to align with.
    poses : (m, 3) float64 array
        Their poses in the map frame.
    frame_points, frame_normals : (k, b, 2) float32 array
        All key frames.
    angle_min, per_radian, turn, side
        See `associate`.
    gates : (i,) float64 array
        Gate of each iteration [m], descending.
    scale : float
        See `add_pairs`; it grows with gates above `WIDE_GATE`.
    deviation : float
        Standard deviation of a distance [m].
    expected : (3,) float64 array
        Mean of the prior in the map frame.
    precision : (3,) float64 array
        Inverse variances of the prior in its own frame [1/m², 1/m², 1/rad²]; above 0.

    Returns
    -------
    pose : (3,) float64 array
    information : (6,) float64 array
        Of the pose in the frame of the scan, with the prior.
    ratio : float
        Part of the points that have a pair in the key frame in which most have one.
    pairs : int
        Number of pairs in all key frames.
    """
    pose, sums, apart = start.copy(), np.zeros(9), np.zeros(3)
    ratio, pairs = 0.0, 0
    final = np.searchsorted(-gates, -gates[-1])  # first iteration with the last gate
    i = 0
    while i < gates.size:
        # Normal equations of all pairs at the current pose.
        sums[:] = 0.0
        ratio, pairs = 0.0, 0
        widened = scale * max(1.0, gates[i] / WIDE_GATE)
        for m in range(near.size):
            relative(poses[m], pose, apart)
            count, readings, _ = add_pairs(
                points, normals, valid, frame_points[near[m]], frame_normals[near[m]], apart,
                angle_min, per_radian, turn, gates[i], widened, side, sums,
            )  # fmt: skip
            pairs += count
            if readings > 0:
                ratio = max(ratio, count / readings)
        sums /= deviation * deviation
        # The prior. Its axes and those of the scan differ by the small angle between the two poses.
        relative(pose, expected, apart)
        sums[0], sums[3], sums[5] = sums[0] + precision[0], sums[3] + precision[1], sums[5] + precision[2]
        for axis in range(3):
            sums[6 + axis] -= precision[axis] * apart[axis]
        # Step, in the frame of the scan.
        dx, dy, dt = solve(sums)
        c, s = math.cos(pose[2]), math.sin(pose[2])
        pose[0] -= c * dx - s * dy
        pose[1] -= s * dx + c * dy
        pose[2] -= dt
        step = max(math.hypot(dx, dy), abs(dt))
        if i >= final and step < STEP:
            break
        # A small step at a wide gate: the start was good, and the other wide gates are skipped.
        i = final if i < final and step < SMALL_STEP else i + 1
    pose[2] = (pose[2] + math.pi) % (2.0 * math.pi) - math.pi
    return pose, sums[:6].copy(), ratio, pairs


@compiled
def linearise(
    first: NDArray[np.int64],
    second: NDArray[np.int64],
    apart: NDArray[np.float64],
    points: NDArray[np.float32],
    normals: NDArray[np.float32],
    valid: NDArray[np.bool_],
    angle_min: float,
    per_radian: float,
    turn: int,
    gate: float,
    scale: float,
    side: int,
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Return the normal equations of each pair of key frames at their relative pose.

    Parameters
    ----------
    first, second : (m,) int64 array
        Indices of the two key frames; the points of the second are paired with those of the first.
    apart : (m, 3) float64 array
        Pose of the second in the frame of the first: x, y [m], theta [rad].
    points, normals, valid
        All key frames, stacked.
    angle_min, per_radian, turn, gate, side
        See `associate`.
    scale : float
        See `add_pairs`.

    Returns
    -------
    sums : (m, 9) float64 array
        In the frame of the second key frame, for points of unit variance.
    counts : (m, 2) int64 array
        Numbers of pairs of points, and of points of the second key frame.
    squares : (m,) float64 array
        Weighted sums of the squared distances [m²].
    """
    sums, squares = np.zeros((first.size, 9)), np.zeros(first.size)
    counts = np.zeros((first.size, 2), np.int64)
    for m in range(first.size):
        i, j = first[m], second[m]
        counts[m, 0], counts[m, 1], squares[m] = add_pairs(
            points[j], normals[j], valid[j], points[i], normals[i], apart[m],
            angle_min, per_radian, turn, gate, scale, side, sums[m],
        )  # fmt: skip
    return sums, counts, squares


def warm() -> None:
    """Call the kernels once, so that they are compiled or loaded from the cache."""
    scan, valid = np.zeros((1, 2), np.float32), np.zeros(1, np.bool_)
    frames, one = np.zeros((1, 1, 2), np.float32), np.ones(3)
    align(
        scan, scan, valid, one, np.zeros(1, np.int64), np.zeros((1, 3)), frames, frames,
        0.0, 1.0, 6, np.ones(1), 0.03, 8, 0.02, one, one,
    )  # fmt: skip
    none = np.zeros(1, np.int64)
    linearise(none, none, np.zeros((1, 3)), frames, frames, valid[np.newaxis], 0.0, 1.0, 6, 1.0, 0.03, 8)
