"""Parts of the maps of floors, around the landings of a lift: small enough to be sent to the clone of a robot."""

import math
import zlib
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ppaas.bounded import inflated
from ppaas.buildings.layout import Landing
from ppaas.errors import InvalidInput, InvalidMap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages.fleet.floors import FloorPart

SIGHT = 8.0
"""Longest beam that is compared with a part of a map [m]."""

REACH = 14.0
"""Distance from the middle of the car to the edges of a part [m]: the lobby in which a robot is looked for, and what it
sees from there."""

BEYOND = 0.3
"""Distance beyond the door from which a robot sees the lobby [m]."""

MOST_CELLS = 1 << 22
"""Largest number of cells of a part."""


class CellRows(Protocol):
    """Map whose rows can be read."""

    @property
    def info(self) -> GridInfo:
        """Geometry of the grid."""
        ...

    def rows(self, first: int, last: int) -> NDArray[np.int8]:
        """Return the cells of these rows."""
        ...


def part_around(grid: CellRows, car: Pose2D, floor: str, elevation: float) -> FloorPart:
    """Return the part of the map of a floor around the middle of a car.

    Raises
    ------
    InvalidMap
        The car is not on the map, or the cells of the map are too small.
    """
    info = grid.info
    cells = math.ceil(REACH / info.resolution)
    row, column = info.to_cells(np.array(car[:2])).tolist()
    first, last = max(row - cells, 0), min(row + cells + 1, info.height)
    left, right = max(column - cells, 0), min(column + cells + 1, info.width)
    if first >= last or left >= right or (last - first) * (right - left) > MOST_CELLS:
        raise InvalidMap(f"floor {floor!r}: no part of its map of at most {MOST_CELLS} cells is around the lift")
    data = np.ascontiguousarray(grid.rows(first, last)[:, left:right])
    origin = info.origin @ Pose2D(left * info.resolution, first * info.resolution)
    return FloorPart(
        floor, elevation, info.resolution, right - left, last - first, [*origin], zlib.compress(data.tobytes(), 6)
    )


def clear_of(landing: Landing, pose: Pose2D | None = None) -> float:
    """Return the distance that a robot drives until it is out of the car [m]; it is in the middle, or has a pose."""
    x, y = landing.door.middle
    away = 0.0 if pose is None else math.hypot(pose.x - landing.car[0], pose.y - landing.car[1])
    return max(math.hypot(x - landing.car[0], y - landing.car[1]) + BEYOND - away, 0.0)


def pose_of(values: Sequence[float]) -> Pose2D:
    """Return the pose of x, y and yaw; ``InvalidInput`` unless these are three finite numbers."""
    if len(values) != 3 or not Pose2D(*values).is_finite():
        raise InvalidInput(f"a pose is three finite numbers, x, y and yaw, not {list(values)!r:.60}")
    return Pose2D(*values)


def grid_of(part: FloorPart) -> GridMap:
    """Return a part of a map as a grid.

    Raises
    ------
    InvalidInput
        Its cells are damaged.
    """
    info = GridInfo(part.resolution, part.width, part.height, pose_of(part.origin))
    cells = part.width * part.height
    if cells > MOST_CELLS:
        raise InvalidInput(f"a part of a map has at most {MOST_CELLS} cells, not {cells}")
    try:
        content = inflated(part.data, cells)
    except zlib.error as error:
        raise InvalidInput(f"the map of floor {part.floor!r} is damaged: {error}") from error
    except OverflowError as error:
        raise InvalidInput(f"the map of floor {part.floor!r} must have {cells} cells, not {error}") from error
    if len(content) != cells:
        raise InvalidInput(f"the map of floor {part.floor!r} must have {cells} cells, not {len(content)}")
    return GridMap(np.frombuffer(content, np.int8).reshape(info.shape), info)
