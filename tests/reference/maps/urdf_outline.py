"""Slow, obvious twin of a robot's extent: matrices, and many points of each surface."""

import numpy as np


def rotation(roll, pitch, yaw):
    """Return the matrix of rotations about the fixed axes x, then y, then z."""
    about_x = [[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]]
    about_y = [[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]]
    about_z = [[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]]
    return np.array(about_z) @ np.array(about_y) @ np.array(about_x)


def matrix(xyz, rpy):
    pose = np.eye(4)
    pose[:3, :3] = rotation(*rpy)
    pose[:3, 3] = xyz
    return pose


def surface(kind, sizes):
    """Return (n, 3) points on the surface of a shape; their extent is exact to 0.1 % of its radius."""
    turns = np.linspace(0.0, 2.0 * np.pi, 120)
    if kind == "box":
        signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        return signs * np.array(sizes) / 2.0
    if kind == "cylinder":
        radius, length = sizes
        circle = np.column_stack([radius * np.cos(turns), radius * np.sin(turns)])
        return np.concatenate([np.column_stack([circle, np.full(120, z)]) for z in (-length / 2, length / 2)])
    if kind == "capsule":
        radius, length = sizes
        ball = surface("sphere", (radius,))
        return np.concatenate([ball + np.array([0.0, 0.0, z]) for z in (-length / 2, length / 2)])
    rows = [
        np.column_stack([np.sin(up) * np.cos(turns), np.sin(up) * np.sin(turns), np.full(120, np.cos(up))])
        for up in np.linspace(0.0, np.pi, 61)
    ]
    return sizes[0] * np.concatenate(rows)


def reach(points, directions):
    """Return the extent of points in each direction."""
    return (points @ np.asarray(directions).T).max(axis=0)
