"""Naive twins of alignment, correlation, counts of beams, and points of scans.

The normal equations take all beams instead of the beams around a bearing.
"""

import numpy as np


def turned(theta):
    return np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])


def belongs(moved, point, normal, gate, increment):
    """Return whether a point is near enough to a point of a key frame, or to its line between two such points."""
    if np.hypot(*(moved - point)) < gate:
        return True
    spacing = (moved @ moved) * increment / abs(normal @ point)
    return abs(normal @ (moved - point)) <= gate and np.hypot(*(moved - point)) <= 0.7 * spacing


def pairs_of(scan, frame, pose, gate, increment):
    """Return (point of the scan, distance, normal in the frame of the scan) of each pair."""
    rotation = turned(pose[2])
    candidates = np.flatnonzero(np.abs(frame.normals).sum(axis=1) > 0.0)
    pairs = []
    for point, normal in zip(scan.points[scan.valid], scan.normals[scan.valid], strict=True):
        moved = rotation @ point + pose[:2]
        distances = np.hypot(*(frame.points[candidates] - moved).T)
        if not len(candidates):
            continue
        k = candidates[distances.argmin()]
        if not belongs(moved, frame.points[k], frame.normals[k], gate, increment):
            continue
        own = rotation.T @ frame.normals[k]
        if np.any(normal) and own @ normal < 0.7:
            continue
        pairs.append((point, frame.normals[k] @ (moved - frame.points[k]), own))
    return pairs


def normal_equations(scan, frame, pose, gate, scale, increment):
    """Return H (3, 3), g (3,) of a motion in the frame of the scan, the number of pairs and the squares."""
    information, gradient, squares = np.zeros((3, 3)), np.zeros(3), 0.0
    pairs = pairs_of(scan, frame, pose, gate, increment)
    for point, error, normal in pairs:
        weight = 1.0 / (1.0 + (error / scale) ** 2) ** 2
        row = np.array([normal[0], normal[1], normal[1] * point[0] - normal[0] * point[1]])
        information += weight * np.outer(row, row)
        gradient += weight * error * row
        squares += weight * error**2
    return information, gradient, len(pairs), squares


def draw(shape, x0, y0, resolution, blur, poses, points, valid):
    """Return the grid as the maximum over one picture per point."""
    half = len(blur) // 2
    grid = np.zeros(shape, np.uint8)
    for pose, scan, is_point in zip(poses, points, valid, strict=True):
        world = scan[is_point] @ turned(pose[2]).T + pose[:2]
        for column, row in np.floor((world - (x0, y0)) / resolution).astype(int):
            if half <= row < shape[0] - half and half <= column < shape[1] - half:
                part = grid[row - half : row + half + 1, column - half : column + half + 1]
                np.maximum(part, blur, out=part)
    return grid


def score(grid, x0, y0, resolution, points, pose):
    """Return the mean likelihood of points at a pose, from 0 to 1."""
    cells = np.floor((points @ turned(pose[2]).T + pose[:2] - (x0, y0)) / resolution).astype(int)
    inside = ((cells >= 0) & (cells < grid.shape[::-1])).all(axis=1)
    return grid[cells[inside, 1], cells[inside, 0]].sum() / 255.0 / len(points)


def count_beams(shape, x0, y0, resolution, poses, points, valid):
    """Return the numbers of beams that end in each cell and that pass it; cells that a beam just touches may miss."""
    ended, passed = np.zeros(shape, int), np.zeros(shape, int)
    for pose, scan, is_point in zip(poses, points, valid, strict=True):
        for end in scan[is_point] @ turned(pose[2]).T + pose[:2]:
            line = pose[:2] + np.linspace(0.0, 1.0, 4000)[:, None] * (end - pose[:2])
            cells = np.floor((line - (x0, y0)) / resolution).astype(int)
            last = tuple(cells[-1, ::-1].tolist())
            for row, column in {(row, column) for column, row in cells.tolist()} - {last}:
                passed[row, column] += 1
            ended[last] += 1
    return ended, passed


def prepare(ranges, laser, parameters, velocity=(0.0, 0.0, 0.0)):
    """Return points, normals and valid, by eigenvectors of the covariance of each neighbourhood."""
    beams = len(ranges)
    points, normals = np.zeros((beams, 2)), np.zeros((beams, 2))
    valid = (ranges > parameters.minimum_laser_range) & (ranges < parameters.max_laser_range)
    for b in np.flatnonzero(valid):
        late = (b - laser.stamped_at * (beams - 1)) * laser.time_increment
        x, y, turn = late * np.asarray(velocity)
        angle = laser.angle_min + b * laser.angle_increment + turn
        points[b] = x + ranges[b] * np.cos(angle), y + ranges[b] * np.sin(angle)
    side = max(2, round(parameters.normal_angle / abs(laser.angle_increment)))
    for b in np.flatnonzero(valid):
        around = [points[k] for k in range(max(0, b - side), min(beams, b + side + 1)) if valid[k]]
        near = within(around, points[b], 0.1 + 0.05 * ranges[b])
        if len(near) < 3 and 0 < b < beams - 1 and valid[b - 1] and valid[b + 1]:
            spacing = max(np.hypot(*(points[b] - points[b - 1])), np.hypot(*(points[b + 1] - points[b])))
            near = within(around, points[b], max(0.1 + 0.05 * ranges[b], min(1.05 * spacing, 0.4 * ranges[b])))
        if len(near) < 3:
            continue
        variances, axes = np.linalg.eigh(np.cov(near.T, bias=True))
        if variances[0] > parameters.normal_thickness**2 or variances[1] < 4.0 * variances[0]:
            continue
        normal = axes[:, 0]
        normals[b] = normal if normal @ points[b] < 0.0 else -normal
    return points, normals, valid


def within(around, point, radius):
    return np.array([other for other in around if np.hypot(*(other - point)) <= radius])
