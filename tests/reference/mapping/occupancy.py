"""Naive twin of the counts of beams: many samples along each beam."""

import numpy as np

from tests.reference.mapping.alignment import turned


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
