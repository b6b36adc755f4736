"""Naive twin of the normal equations of a scan with a key frame, over all beams instead of those around a bearing."""

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
