"""Costmaps for tests, written as pictures or drawn at random."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap, Indexes
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo

SIGNS = {".": 0, "o": 128, "h": 252, "i": 253, "#": 254, "?": 255}


def costmap(picture: str, resolution: float = 1.0, origin: Pose2D = Pose2D(0.0, 0.0)) -> Costmap:
    """Return the costmap of a picture, the lowest row last, with the characters of `SIGNS`."""
    lines = [line.strip() for line in picture.strip().splitlines()][::-1]
    return of(np.array([[SIGNS[sign] for sign in line] for line in lines], dtype=np.uint8), resolution, origin)


def of(
    data: NDArray[np.uint8],
    resolution: float = 1.0,
    origin: Pose2D = Pose2D(0.0, 0.0),
    indexes: Indexes | None = None,
) -> Costmap:
    """Return the costmap of an array."""
    return Costmap(data, GridInfo(resolution, data.shape[1], data.shape[0], origin), indexes)


def centre(costmap: Costmap, row: int, column: int, theta: float = 0.0) -> Pose2D:
    """Return the pose at the centre of a cell."""
    x, y = costmap.info.to_world((row, column)).tolist()
    return Pose2D(x, y, theta)


def cost_arrays(most: int = 12) -> st.SearchStrategy[NDArray[np.uint8]]:
    """Draw small arrays of costs in which free, graded, blocked and unknown cells are all common."""
    values = st.one_of(st.sampled_from([0, 0, 0, 1, 128, 252, 253, 254, 255]), st.integers(min_value=0, max_value=255))
    shapes = st.tuples(st.integers(1, most), st.integers(1, most))
    return hnp.arrays(np.uint8, shapes, elements=values)


def free_cells(costs: NDArray[np.uint8], allow_unknown: bool) -> list[tuple[int, int]]:
    """Return row and column of each cell that a plan may pass."""
    free = (costs < 253) | ((costs == 255) & allow_unknown)
    return [(int(r), int(c)) for r, c in np.argwhere(free)]


@st.composite
def scenes(draw: st.DrawFn, most: int = 12) -> tuple[NDArray[np.uint8], list[tuple[int, int]], bool]:
    """Draw a small map, one to three goals on it, and whether unknown cells may be entered."""
    costs = draw(cost_arrays(most))
    allow_unknown = draw(st.booleans())
    free = free_cells(costs, allow_unknown)
    if not free:
        costs[0, 0] = 0
        free = [(0, 0)]
    return costs, draw(st.lists(st.sampled_from(free), min_size=1, max_size=3)), allow_unknown


def keeps_its_changes(costmap: Costmap, base: Costmap) -> bool:
    """Return whether all cells that differ from a read-only costmap are in the windows that a copy of it keeps."""
    assert costmap.changes is not None
    assert costmap.changes.base is base.data
    within = np.zeros(base.data.shape, np.bool_)
    for window in costmap.changes.windows:
        within[window] = True
    return not (costmap.data != base.data)[~within].any()
