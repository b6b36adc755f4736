"""Twins of the kernels of loop closures."""

import math

import numpy as np


def gather(points, valid, poses, frame):
    """Return valid points of scans in a common frame."""
    c0, s0 = math.cos(frame[2]), math.sin(frame[2])
    back = np.array([[c0, s0], [-s0, c0]])
    found = []
    for scan, ok, (x, y, theta) in zip(points, valid, poses, strict=True):
        c, s = math.cos(theta), math.sin(theta)
        found.append((scan[ok].astype(float) @ np.array([[c, s], [-s, c]]) + (x, y) - frame[:2]) @ back.T)
    return np.concatenate(found)


def thin(points, size, reach):
    """Return the mean of the points of each cell, as a set of rows."""
    cells = {}
    n = math.ceil(2 * reach / size)
    for x, y in points:
        u, v = math.floor((x + reach) / size), math.floor((y + reach) / size)
        if 0 <= u < n and 0 <= v < n:
            cells.setdefault((v, u), []).append((x, y))
    return np.array([np.mean(cells[key], axis=0) for key in sorted(cells)]).reshape(-1, 2)


def blurred_grid(points, x0, y0, resolution, height, width, blur):
    """Return the largest blur value at each cell."""
    r = len(blur) // 2
    grid = np.zeros((height, width), int)
    for x, y in points:
        u, v = math.floor((x - x0) / resolution), math.floor((y - y0) / resolution)
        if not (0 <= u < width and 0 <= v < height):
            continue
        for row in range(height):
            for column in range(width):
                if abs(row - v) <= r and abs(column - u) <= r:
                    grid[row, column] = max(grid[row, column], blur[row - v + r][column - u + r])
    return grid


def score(grid, points, turn, du, dv, corner, resolution):
    """Return the sum of the grid's values under points, rotated and then moved by whole cells."""
    c, s = math.cos(turn), math.sin(turn)
    total = 0
    for x, y in points:
        u = math.floor((c * x - s * y - corner[0]) / resolution) + du
        v = math.floor((s * x + c * y - corner[1]) / resolution) + dv
        if 0 <= u < grid.shape[1] and 0 <= v < grid.shape[0]:
            total += int(grid[v, u])
    return total


def all_scores(grid, points, turns, half, corner, resolution):
    """Return the sums of all motions of a window by (turn, du, dv)."""
    return {
        (a, du, dv): score(grid, points, turn, du, dv, corner, resolution)
        for a, turn in enumerate(turns)
        for du in range(-half[0], half[0] + 1)
        for dv in range(-half[1], half[1] + 1)
    }


def path_moments(root, n, edges, positions):
    """Return the sums along shortest paths, by Bellman and Ford; edges are (i, j, length, sign)."""
    moments = np.zeros((n, 9))
    moments[:, 0] = np.inf
    moments[root] = 0.0
    for _ in range(n):
        for i, j, length, sign in [*edges, *((j, i, length, -sign) for i, j, length, sign in edges)]:
            if moments[i, 0] + length < moments[j, 0]:
                x, y = (positions[i] + positions[j]) / 2
                step = [1, x, y, x * x, x * y, y * y]
                moments[j] = moments[i] + length * np.array([*step, sign, sign * x, sign * y])
    return moments


def agreement(points, valid, other_points, other_valid, pose, angle_min, angle_increment, tolerance):
    """Return the numbers of points of a scan that another one confirms and contradicts."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    confirmed = contradicted = 0
    for (px, py), ok in zip(points, valid, strict=True):
        x, y = pose[0] + c * px - s * py, pose[1] + s * px + c * py
        turn = (math.atan2(y, x) - angle_min) % (2 * math.pi)
        beam = math.floor(turn / angle_increment + 0.5)
        around = range(beam - 1, beam + 2)
        if not ok or beam < 1 or beam >= len(other_points) - 1 or not all(other_valid[k] for k in around):
            continue
        ends = [math.hypot(*other_points[k]) for k in around]
        r = math.hypot(x, y)
        contradicted += r < min(ends) - tolerance
        confirmed += min(ends) - tolerance <= r <= max(ends) + tolerance
    return confirmed, contradicted
