"""Naive twins of the likelihood grid and of the search on it."""

import numpy as np

from tests.reference.mapping.alignment import turned


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
