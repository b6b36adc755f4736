"""Features of the shape of a surface: its relief around head and shoulders, and its width at each height."""

import numpy as np
from numpy.typing import NDArray

from ppaas.perception.torso.floor_view import FloorPoints, FloorView

COLUMNS, COLUMN_WIDTH = 32, 0.03125
"""Number of columns, and width of each [m]."""

BELOW_TOP = (0.20 - 0.05 * np.arange(25)).astype(np.float32)
"""Heights of rows above the top of the head [m]."""

ABOVE_FLOOR = (0.10 + 0.05 * np.arange(10)).astype(np.float32)
"""Heights of the other rows above the floor, at the legs [m]."""

ROWS = len(BELOW_TOP) + len(ABOVE_FLOOR)
"""Number of rows."""

EDGES = np.array(
    [-0.40, -0.25, -0.15, -0.10, -0.06, -0.03, 0.0, 0.03, 0.06, 0.10, 0.15, 0.20, 0.25, 0.30, 0.40, 0.60], np.float32
)
"""Limits of the steps of depth behind the chest [m]."""

OUTSIDE, NO_READING, FIRST = 0, 1, 2
"""Steps of cells outside the image and without a reading, and the first step of depth."""

LEVELS = 32
"""Number of values of a feature."""

SAME = 0.2
"""Difference of depth up to which neighbours in a row belong to the same body [m]."""

BLOCK = 2, 4
"""Rows and columns of the blocks whose mean steps are features, too: they have less noise than cells."""

FEATURES = ROWS * COLUMNS + (ROWS // BLOCK[0]) * (COLUMNS // BLOCK[1]) + 3 * ROWS + 3
"""Number of features."""

_ACROSS = ((np.arange(COLUMNS) - (COLUMNS - 1) / 2) * COLUMN_WIDTH).astype(np.float32)
_CHEST = slice(11, 17), slice(12, 20)
"""Cells whose median depth is the chest's."""


def features_at(
    view: FloorView,
    points: FloorPoints,
    places: NDArray[np.float32],
    tops: NDArray[np.float32],
    odds: NDArray[np.float32],
) -> NDArray[np.uint8]:
    """Return the features of surfaces, (n, `FEATURES`) uint8, each below `LEVELS`.

    They are the steps of depth of all cells and of blocks of them, from top to bottom and from right to left; of each
    row, the widths of the body to the right and to the left of its centre, and the number of cells at the depth of the
    body; and the distance, the height of the head and the odds.

    Parameters
    ----------
    view : FloorView
        View of the camera.
    points : FloorPoints
        Points of its image.
    places : (n, 2) float32 array
        Centres of the surfaces over the floor [m].
    tops : (n,) float32 array
        Heights of the tops of the heads [m].
    odds : (n,) float32 array
        Log odds of the templates.
    """
    behind, inside, distance = _relief(view, points, places, tops)
    behind -= _chest(behind)[:, None, None]
    steps = np.full(behind.shape, FIRST, np.uint8)
    for edge in EDGES:
        steps += behind > edge
    steps[np.isnan(behind)] = NO_READING
    steps[~inside] = OUTSIDE
    others = np.stack([distance / 0.25, (tops - 1.0) / 0.05, odds + 6.0], 1)
    scaled = np.clip(np.rint(others), 0, LEVELS - 1).astype(np.uint8)
    return np.concatenate([steps.reshape(len(places), -1), _blocks(steps), _widths(behind), scaled], axis=1)


def mirrored(features: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the features of the mirror images of surfaces."""
    cells, blocks = ROWS * COLUMNS, (ROWS // BLOCK[0]) * (COLUMNS // BLOCK[1])
    widths = cells + blocks
    flipped = features.copy()
    for begin, end, columns in ((0, cells, COLUMNS), (cells, widths, COLUMNS // BLOCK[1])):
        part = features[:, begin:end].reshape(len(features), -1, columns)
        flipped[:, begin:end] = part[:, :, ::-1].reshape(len(features), -1)
    flipped[:, widths : widths + ROWS] = features[:, widths + ROWS : widths + 2 * ROWS]
    flipped[:, widths + ROWS : widths + 2 * ROWS] = features[:, widths : widths + ROWS]
    return flipped


def _relief(
    view: FloorView, points: FloorPoints, places: NDArray[np.float32], tops: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.bool_], NDArray[np.float32]]:
    """Return the depths behind the surfaces (n, rows, columns) [m], the cells in the image, and the distances [m]."""
    x, y = places.T
    ahead_x, ahead_y = x - np.float32(view.origin[0]), y - np.float32(view.origin[1])
    distance = np.hypot(ahead_x, ahead_y)
    ahead_x, ahead_y = ahead_x / distance, ahead_y / distance
    heights = np.concatenate(
        [tops[:, None] + BELOW_TOP, np.broadcast_to(ABOVE_FLOOR, (len(tops), len(ABOVE_FLOOR)))], axis=1
    )
    index, inside = view.pixels(
        (x[:, None] - ahead_y[:, None] * _ACROSS)[:, None, :],
        (y[:, None] + ahead_x[:, None] * _ACROSS)[:, None, :],
        heights[:, :, None],
    )
    behind = np.take(points.x, index) * ahead_x[:, None, None] + np.take(points.y, index) * ahead_y[:, None, None]
    behind -= (x * ahead_x + y * ahead_y)[:, None, None]
    behind[~inside] = np.nan
    return behind, inside, distance


def _chest(behind: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the depth of each chest behind its place [m]; 0 if little of it is seen."""
    cells = behind[:, *_CHEST].reshape(len(behind), -1)
    near = np.where(np.abs(cells) < SAME, cells, np.nan)
    seen = np.count_nonzero(~np.isnan(near), axis=1) >= 4
    depth = np.zeros(len(behind), np.float32)
    if seen.any():
        depth[seen] = np.nanmedian(near[seen], axis=1)
    return depth


def _blocks(steps: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the mean steps of blocks, scaled to `LEVELS`, (n, number of blocks)."""
    rows, columns = ROWS // BLOCK[0], COLUMNS // BLOCK[1]
    blocks = steps[:, : rows * BLOCK[0]].reshape(len(steps), rows, BLOCK[0], columns, BLOCK[1])
    scale = (LEVELS - 1) / (FIRST + len(EDGES)) / (BLOCK[0] * BLOCK[1])
    means = np.rint(blocks.sum(axis=(2, 4), dtype=np.float32) * np.float32(scale))
    levels: NDArray[np.uint8] = means.reshape(len(steps), -1).astype(np.uint8)
    return levels


def _widths(behind: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return for each row the widths to the right and to the left, and the number of cells of the body, (n, 3 rows)."""
    body, half = np.abs(behind) < SAME, COLUMNS // 2
    right = np.cumprod(body[:, :, half - 1 :: -1], axis=2, dtype=np.uint8).sum(axis=2, dtype=np.uint8)
    left = np.cumprod(body[:, :, half:], axis=2, dtype=np.uint8).sum(axis=2, dtype=np.uint8)
    cells = np.minimum(body.sum(axis=2), LEVELS - 1).astype(np.uint8)
    return np.concatenate([right, left, cells], axis=1)
