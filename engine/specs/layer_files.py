"""The layers of a map as files: one ``.npy`` a layer, which every process of a machine maps into its memory."""

import mmap
import os
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidMap, Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.occupancy import to_message
from ppaas.messages import encode
from ppaas.messages.std_msgs import Time

MAP_JSON = "map.json"
"""The map as JSON of ``nav_msgs/OccupancyGrid``, ready to be sent."""

INDEX = ".index"
"""Ending of the file in which something lies that a planner, whose name comes before it, has prepared of the map."""

_INFO = "info.json"


class _Layer(msgspec.Struct, frozen=True):
    dtype: str
    offset: int


class _Info(msgspec.Struct, frozen=True):
    resolution: float
    width: int
    height: int
    origin: tuple[float, float, float]
    layers: dict[str, _Layer]


def write_layers(folder: Path, layers: MapLayers, created: float) -> None:
    """Write the layers of a map into a folder.

    Parameters
    ----------
    folder : Path
        Where to.
    layers : MapLayers
        What.
    created : float
        When the map was made [s since the epoch].

    Raises
    ------
    Unavailable
        There is no room.
    """
    message = encode(to_message(layers.grid, stamp=Time.of(created)))
    info = layers.grid.info
    arrays = _arrays_of(layers)
    try:
        (folder / MAP_JSON).write_bytes(message)
        written = {name: _write(folder / f"{name}.npy", array) for name, array in arrays.items()}
        origin = (info.origin.x, info.origin.y, info.origin.theta)
        header = _Info(info.resolution, info.width, info.height, origin, written)
        (folder / _INFO).write_bytes(msgspec.json.encode(header))
    except OSError as error:  # numpy tells a full disk without its number
        size = (len(message) + sum(array.nbytes for array in arrays.values())) / 2**20
        raise Unavailable(f"{size:.1f} MB of map layers cannot be written to {folder.parent}: {error}") from error


def _arrays_of(layers: MapLayers) -> dict[str, NDArray[Any]]:
    arrays: dict[str, NDArray[Any]] = {
        "grid": layers.grid.data,
        "costmap": layers.costmap.data,
        "distance": layers.distance,
    }
    if layers.keepout is not None and layers.barred_distance is not None:
        arrays |= {"keepout": layers.keepout.data, "barred_distance": layers.barred_distance}
    if layers.speed is not None:
        arrays["speed"] = layers.speed.data
    return arrays


def _write(path: Path, array: NDArray[Any]) -> _Layer:
    np.save(path, np.ascontiguousarray(array), allow_pickle=False)
    return _Layer(array.dtype.str, path.stat().st_size - array.nbytes)


def open_layers(folder: Path) -> MapLayers:
    """Map the layers in a folder into this process; nothing is copied, and nothing can be written.

    Raises
    ------
    Unavailable
        They are not there, or not whole.
    """
    try:
        header = msgspec.json.decode((folder / _INFO).read_bytes(), type=_Info)
        info = GridInfo(header.resolution, header.width, header.height, Pose2D(*header.origin))
        arrays = {name: _map_array(folder / f"{name}.npy", layer, info.shape) for name, layer in header.layers.items()}
        grids = {name: GridMap(arrays[name], info) for name in ("keepout", "speed") if name in arrays}
        return MapLayers(
            GridMap(arrays["grid"], info),
            Costmap(arrays["costmap"], info),
            arrays["distance"],
            barred_distance=arrays.get("barred_distance"),
            **grids,
        )
    except (OSError, KeyError, ValueError, InvalidMap, msgspec.DecodeError) as error:
        raise Unavailable(f"no layers of a map in {folder}: {error}") from error


def cells_in(folder: Path) -> int:
    """Return how many cells the map has of which the layers are in a folder; none where there are no layers."""
    try:
        header = msgspec.json.decode((folder / _INFO).read_bytes(), type=_Info)
    except (OSError, msgspec.DecodeError):
        return 0
    return header.width * header.height


def _map_array(path: Path, layer: _Layer, shape: tuple[int, int]) -> NDArray[Any]:
    # Not by numpy's own loader: it parses the header as Python, which takes a container 1 ms and 0.6 MB of its own.
    with path.open("rb") as file:
        memory = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    return np.frombuffer(memory, layer.dtype, offset=layer.offset).reshape(shape)


def write_index(folder: Path, planner: str, content: memoryview) -> None:
    """Put what a planner has prepared of a map beside its layers; it appears whole or not at all.

    Raises
    ------
    Unavailable
        There is no room, or the folder is gone.
    """
    aside = folder / f".{planner}-{os.getpid()}"
    try:
        try:
            aside.write_bytes(content)
            aside.rename(folder / f"{planner}{INDEX}")
        finally:
            aside.unlink(missing_ok=True)
    except OSError as error:
        size = content.nbytes / 2**20
        raise Unavailable(f"an index of {size:.1f} MB cannot be written to {folder}: {error}") from error


def open_index(folder: Path, planner: str) -> memoryview | None:
    """Map what a planner has prepared into this process, so that nobody can write to it; None if it is not there.

    Raises
    ------
    Unavailable
        It cannot be read.
    """
    try:
        with (folder / f"{planner}{INDEX}").open("rb") as file:
            return memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise Unavailable(f"the index of {planner} in {folder} cannot be read: {error}") from error
