"""Grids as ``nav_msgs/OccupancyGrid``, and back."""

from dataclasses import dataclass
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.grid import OCCUPIED, UNKNOWN, GridInfo, GridMap
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.nav_msgs import MapMetaData, OccupancyGrid
from ppaas.messages.std_msgs import Header, Time

# The text of each cell by its byte, all of one width, so that one look-up writes the whole grid; the blanks go after.
_TEXT = np.full(256, b"    ", "S4")
_TEXT[np.arange(UNKNOWN, OCCUPIED + 1)] = [f"{value},".ljust(4).encode() for value in range(UNKNOWN, OCCUPIED + 1)]
_TEXT = _TEXT.view(np.uint32)

_CELLS = msgspec.json.Decoder(list[Annotated[int, msgspec.Meta(ge=UNKNOWN, le=OCCUPIED)]])


def to_message(grid: GridMap, frame_id: str = "map", stamp: Time | None = None) -> OccupancyGrid:
    """Return the message of a grid; its cells are JSON already, which the encoder copies as it is.

    Parameters
    ----------
    grid : GridMap
        The map.
    frame_id : str
        Frame that the origin is given in.
    stamp : Time, optional
        When the map was made or loaded; without it zero.

    Raises
    ------
    InvalidMap
        A cell is not from −1 to 100.
    """
    _check_range(grid.data)
    stamp = stamp or Time()
    info = grid.info
    meta = MapMetaData(info.resolution, info.width, info.height, Pose.of(info.origin), stamp)
    text = np.take(_TEXT, grid.data.view(np.uint8)).tobytes().translate(None, b" ")
    return OccupancyGrid(Header(stamp=stamp, frame_id=frame_id), meta, msgspec.Raw(b"[%b]" % text[:-1]))


def from_message(message: OccupancyGrid) -> GridMap:
    """Return the grid of a message, whether its cells are numbers or JSON.

    Raises
    ------
    InvalidMap
        A cell is no integer from −1 to 100, there are not as many as width × height, or the metadata is no grid's.
    """
    meta = message.info
    info = GridInfo(meta.resolution, meta.width, meta.height, meta.origin.planar())
    try:
        cells = _CELLS.decode(message.data) if isinstance(message.data, msgspec.Raw) else message.data
        data = np.fromiter(cells, np.int64, len(cells))
    except (msgspec.DecodeError, UnicodeDecodeError, TypeError, ValueError, OverflowError) as error:
        raise InvalidMap(f"the cells of an occupancy grid are integers from −1 to 100: {error}") from error
    if data.size != info.width * info.height:
        raise InvalidMap(f"{info.width}×{info.height} cells were announced and {data.size} sent")
    _check_range(data)
    return GridMap(data.astype(np.int8).reshape(info.shape), info)


def _check_range(data: NDArray[np.integer]) -> None:
    if data.min() < UNKNOWN or data.max() > OCCUPIED:
        raise InvalidMap(f"cells are from −1 to 100, not from {data.min()} to {data.max()}")


@dataclass(frozen=True, slots=True)
class GridMapMessage:
    """A grid that travels by reference inside a home and becomes a message where it leaves.

    Parameters
    ----------
    grid : GridMap
        The map.
    frame_id : str
        Frame that the origin is given in.
    stamp : Time, optional
        When the map was made or loaded.
    """

    grid: GridMap
    frame_id: str = "map"
    stamp: Time | None = None

    def to_message(self) -> OccupancyGrid:
        """Return ``nav_msgs/OccupancyGrid``."""
        return to_message(self.grid, self.frame_id, self.stamp)
