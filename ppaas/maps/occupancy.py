"""Conversion between grids and ``nav_msgs/OccupancyGrid``."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.grid import OCCUPIED, UNKNOWN, GridInfo, GridMap
from ppaas.messages.base.map_msgs import OccupancyGridUpdate
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.nav_msgs import MapMetaData, OccupancyGrid

# Text of a cell by its byte, padded to four characters, so that one look-up yields the text of the whole grid. The
# blanks are removed afterwards.
_TEXT = np.full(256, b"    ", "S4")
_TEXT[np.arange(UNKNOWN, OCCUPIED + 1)] = [f"{value},".ljust(4).encode() for value in range(UNKNOWN, OCCUPIED + 1)]
_TEXT = _TEXT.view(np.uint32)

_CELLS = msgspec.json.Decoder(list[Annotated[int, msgspec.Meta(ge=UNKNOWN, le=OCCUPIED)]])


def to_message(grid: GridMap, frame_id: str = "map", stamp: Time | None = None) -> OccupancyGrid:
    """Return the message of a grid. Its cells are already JSON, which the encoder copies unchanged.

    Parameters
    ----------
    grid : GridMap
        The map.
    frame_id : str
        Frame of the grid's origin.
    stamp : Time, optional
        Time at which the map was made or loaded; by default zero.

    Raises
    ------
    InvalidMap
        A cell is not from −1 to 100.
    """
    _check_range(grid.data)
    stamp = stamp or Time()
    info = grid.info
    meta = MapMetaData(info.resolution, info.width, info.height, Pose.of(info.origin), stamp)
    return OccupancyGrid(Header(stamp=stamp, frame_id=frame_id), meta, _as_json(grid.data))


def to_update(cells: NDArray[np.int8], row: int, column: int, header: Header) -> OccupancyGridUpdate:
    """Return the message of a rectangle of cells that changed.

    Parameters
    ----------
    cells : (h, w) int8 array
        New values, from −1 to 100.
    row, column : int
        Lower-left cell of the rectangle.
    header : Header
        Frame of the map, and time of the change.

    Raises
    ------
    InvalidMap
        A cell is not from −1 to 100.
    """
    _check_range(cells)
    height, width = cells.shape
    return OccupancyGridUpdate(header, column, row, width, height, _as_json(np.ascontiguousarray(cells)))


def from_message(message: OccupancyGrid) -> GridMap:
    """Return the grid of a message, whose cells may be a list or encoded JSON.

    Raises
    ------
    InvalidMap
        A cell is not an integer from −1 to 100, there are not width × height cells, or the metadata is invalid.
    """
    meta = message.info
    info = GridInfo(meta.resolution, meta.width, meta.height, meta.origin.planar())
    return GridMap(_cells_of(message.data, info.height, info.width), info)


def from_update(message: OccupancyGridUpdate) -> tuple[int, int, NDArray[np.int8]]:
    """Return row and column of the lower-left cell of a change, and its (h, w) cells.

    Raises
    ------
    InvalidMap
        A cell is not an integer from −1 to 100, or there are not width × height cells.
    """
    if not (message.width and message.height):
        raise InvalidMap(f"an update must have cells, not {message.width}×{message.height}")
    return message.y, message.x, _cells_of(message.data, message.height, message.width)


def _cells_of(cells: Sequence[int] | msgspec.Raw, height: int, width: int) -> NDArray[np.int8]:
    try:
        values = _CELLS.decode(cells) if isinstance(cells, msgspec.Raw) else cells
        data = np.fromiter(values, np.int64, len(values))
    except (msgspec.DecodeError, UnicodeDecodeError, TypeError, ValueError, OverflowError) as error:
        raise InvalidMap(f"cells of an occupancy grid must be integers from −1 to 100: {error}") from error
    if data.size != width * height:
        raise InvalidMap(f"info gives {width}×{height} cells, but data has {data.size}")
    _check_range(data)
    return data.astype(np.int8).reshape(height, width)


def _as_json(cells: NDArray[np.int8]) -> msgspec.Raw:
    text = np.take(_TEXT, cells.view(np.uint8)).tobytes().translate(None, b" ")
    return msgspec.Raw(b"[%b]" % text[:-1])


def _check_range(data: NDArray[np.integer]) -> None:
    if data.min() < UNKNOWN or data.max() > OCCUPIED:
        raise InvalidMap(f"cells must be from −1 to 100; they are from {data.min()} to {data.max()}")


@dataclass(frozen=True, slots=True)
class GridMapMessage:
    """Grid that nodes of one process pass by reference, converted to a message only when it leaves the process.

    Parameters
    ----------
    grid : GridMap
        The map.
    frame_id : str
        Frame of the grid's origin.
    stamp : Time, optional
        Time at which the map was made or loaded.
    """

    grid: GridMap
    frame_id: str = "map"
    stamp: Time | None = None

    def to_message(self) -> OccupancyGrid:
        """Return ``nav_msgs/OccupancyGrid``."""
        return to_message(self.grid, self.frame_id, self.stamp)


@dataclass(frozen=True, slots=True)
class GridUpdate:
    """New cells of a rectangle of the map, converted to a message only when they leave the process.

    Parameters
    ----------
    cells : (h, w) int8 array
    row, column : int
        Lower-left cell.
    stamp : Time
    frame_id : str
        Frame of the map.
    """

    cells: NDArray[np.int8]
    row: int
    column: int
    stamp: Time
    frame_id: str = "map"

    def to_message(self) -> OccupancyGridUpdate:
        """Return ``map_msgs/OccupancyGridUpdate``."""
        return to_update(self.cells, self.row, self.column, Header(stamp=self.stamp, frame_id=self.frame_id))
