"""Changes of a map: places where two passes of a robot found something gone, or something new."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.lifelong.changed_places import NOTHING, Centres, ChangedPlace, KnownChanges, is_among
from ppaas.mapping.lifelong.passes import CellPasses, mileage
from ppaas.maps.grid import FREE, OCCUPIED, OCCUPIED_THRESHOLD, UNKNOWN, GridInfo, GridMap

PASSES = 2
"""Number of passes that confirm a change."""

NEAR = 2
"""Distance within which an occupied cell may move without being a change [cells]: walls are rarely thinner."""

SQUARE = 4
"""Edge of the squares of which the rectangles around changes consist [cells]."""

LEAST_CELLS = 6
"""Fewest cells of a change; fewer are noise at the edge of a wall."""

MOST_PLACES = 64
"""Largest number of changes of a kind that are found at once; the others are found when these are known."""

SAME_SCAN = 0.1
"""Largest median distance of the scans that a robot shares with the map [m]: above, their frames differ."""


@dataclass(frozen=True, slots=True)
class ConfirmedChanges:
    """Changes that two passes confirm.

    Parameters
    ----------
    left, new : list of ChangedPlace
        Where something stood before, and where something is now; the `MOST_PLACES` largest of each, largest first.
    grid : GridMap
        The map with these changes; cells that were unknown are as the robot sees them.
    """

    left: list[ChangedPlace]
    new: list[ChangedPlace]
    grid: GridMap


class LaterFrames(NamedTuple):
    """Key frames of a robot that are not in the map that it continues.

    Parameters
    ----------
    frames : KeyFrames
        All of the robot.
    indices : (n,) int64 array
        Those that are not in the map.
    """

    frames: KeyFrames
    indices: NDArray[np.int64]


def later_frames(frames: KeyFrames, published: KeyFrames) -> LaterFrames:
    """Return the key frames of a robot that are not in the map that it continues.

    Parameters
    ----------
    frames, published : KeyFrames
        The robot's, and the map's.

    Raises
    ------
    InvalidInput
        The robot does not continue this map, or its frame is another one.
    """
    if not np.array_equal(frames.points[0], published.points[0]):
        raise InvalidInput("the robot does not continue this map: its first key frame is another one")
    own, theirs = _common(frames, published)
    if not len(own):
        raise InvalidInput("the robot does not continue this map: it has no key frame in common with it")
    apart = frames.poses[own, :2] - published.poses[theirs, :2]
    if np.median(np.hypot(apart[:, 0], apart[:, 1])) > SAME_SCAN:
        raise InvalidInput("the robot does not continue this map: its key frames are at other places")
    later = np.ones(len(frames), np.bool_)
    later[own] = False
    return LaterFrames(frames, np.flatnonzero(later))


def confirmed_changes(
    before: GridMap, now: GridMap, later: LaterFrames, apart: float, known: KnownChanges = NOTHING
) -> ConfirmedChanges:
    """Return the changes of a map that two passes of a robot confirm.

    Parameters
    ----------
    before : GridMap
        The map.
    now : GridMap
        The map that the robot has made of all key frames; with the same resolution and axes, and cells that coincide.
    later : LaterFrames
    apart : float
        Least distance travelled between two passes [m].
    known : KnownChanges
        Changes that are left out.

    Raises
    ------
    InvalidInput
        The cells of the two grids do not coincide.
    """
    info = _around(before.info, now.info)
    old, current = _extended(before, info), _extended(now, info)
    was, is_ = old >= OCCUPIED_THRESHOLD, current >= OCCUPIED_THRESHOLD
    passes = CellPasses(info, apart)
    passes.add(later.frames, later.indices, mileage(later.frames.poses))
    left = was & ~_widened(is_, NEAR) & (current != UNKNOWN) & (_most_beside(passes.passed) >= PASSES)
    new = is_ & ~_widened(was, NEAR) & (old != UNKNOWN) & (_most_beside(passes.ended) >= PASSES)
    left_places, left = _places(left, info, known.left)
    new_places, new = _places(new, info, known.new)
    cells = np.where(old == UNKNOWN, current, old)
    cells[left], cells[new] = FREE, OCCUPIED
    return ConfirmedChanges(left_places, new_places, GridMap(cells, info))


def _common(frames: KeyFrames, published: KeyFrames) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the indices of equal key frames in both maps; scans of two robots that continue one have equal numbers."""
    _, own, theirs = np.intersect1d(frames.scans, published.scans, assume_unique=True, return_indices=True)
    both = frames.valid[own] & published.valid[theirs]  # outdated beams have left one of them
    same = ((frames.points[own] == published.points[theirs]).all(axis=2) | ~both).all(axis=1)
    return own[same], theirs[same]


def _around(one: GridInfo, other: GridInfo) -> GridInfo:
    """Return the smallest grid around two, whose cells coincide with theirs."""
    shift = one.shift_to(other)
    if shift is None:
        raise InvalidInput("the cells of the two grids do not coincide: their resolutions or origins differ")
    row, column = -shift[0], -shift[1]  # of the other grid in the first one
    bottom, left = min(0, row), min(0, column)
    top, right = max(one.height, row + other.height), max(one.width, column + other.width)
    origin = one.origin._replace(x=one.origin.x + left * one.resolution, y=one.origin.y + bottom * one.resolution)
    return GridInfo(one.resolution, right - left, top - bottom, origin)


def _extended(grid: GridMap, info: GridInfo) -> NDArray[np.int8]:
    cells = np.full(info.shape, UNKNOWN, np.int8)
    shift = grid.info.shift_to(info)
    assert shift is not None
    cells[shift[0] : shift[0] + grid.info.height, shift[1] : shift[1] + grid.info.width] = grid.data
    return cells


def _widened(mask: NDArray[np.bool_], by: int) -> NDArray[np.bool_]:
    """Return a mask of all cells within a distance of another mask's cells."""
    widened = mask.copy()
    for axis in (0, 1):
        rows = np.moveaxis(widened, axis, 0)
        original = rows.copy()
        for step in range(1, by + 1):
            rows[step:] |= original[:-step]
            rows[:-step] |= original[step:]
    return widened


def _most_beside(counts: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the largest count among each cell and the cells beside it."""
    most = counts.copy()
    for axis in (0, 1):
        rows = np.moveaxis(most, axis, 0)
        original = rows.copy()
        np.maximum(rows[1:], original[:-1], out=rows[1:])
        np.maximum(rows[:-1], original[1:], out=rows[:-1])
    return most


def _places(mask: NDArray[np.bool_], info: GridInfo, known: Centres) -> tuple[list[ChangedPlace], NDArray[np.bool_]]:
    """Return rectangles around the largest groups of cells that are not known, and the mask of these groups."""
    rows, columns = np.nonzero(mask)
    squares, index, counts = np.unique(
        np.column_stack((rows // SQUARE, columns // SQUARE)), axis=0, return_inverse=True, return_counts=True
    )
    groups = _groups(squares)
    sizes = np.bincount(groups, counts, minlength=1).astype(np.int64)
    sorted_cells, ends = np.argsort(groups[index.ravel()], kind="stable"), np.cumsum(sizes)
    kept, places = np.zeros_like(mask), list[ChangedPlace]()
    for group in np.argsort(-sizes, kind="stable"):
        if sizes[group] < LEAST_CELLS or len(places) == MOST_PLACES:
            break
        own = sorted_cells[ends[group] - sizes[group] : ends[group]]
        place = _place(rows[own], columns[own], info)
        if not is_among(place, known):
            kept[rows[own], columns[own]] = True
            places.append(place)
    return places, kept


def _place(rows: NDArray[np.int64], columns: NDArray[np.int64], info: GridInfo) -> ChangedPlace:
    left, right, bottom, top = columns.min(), columns.max() + 1, rows.min(), rows.max() + 1
    size = info.resolution
    x, y = info.origin.x + 0.5 * (left + right) * size, info.origin.y + 0.5 * (bottom + top) * size
    return ChangedPlace(float(x), float(y), float((right - left) * size), float((top - bottom) * size), len(rows))


def _groups(squares: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the number of the group of each square (n, 2): those that touch are one."""
    at = {square: number for number, square in enumerate(map(tuple, squares.tolist()))}
    groups, count = np.full(len(squares), -1), 0
    for number, start in enumerate(at):
        if groups[number] >= 0:
            continue
        waiting, groups[number] = [start], count
        while waiting:
            row, column = waiting.pop()
            for beside in ((row + r, column + c) for r in (-1, 0, 1) for c in (-1, 0, 1)):
                other = at.get(beside, -1)
                if other >= 0 and groups[other] < 0:
                    groups[other] = count
                    waiting.append(beside)
        count += 1
    return groups
