"""Files of map layers: one ``.npy`` for each layer, which all processes of a machine map into memory."""

import mmap
import os
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.costmap.map_layers import MapLayers, with_causes
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.cell_rectangle import Rectangle, changed_rectangles
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.occupancy import to_message
from ppaas.messages import encode
from ppaas.messages.base.std_msgs import Time
from ppaas.zones.reading import geojson_of, zones_of
from ppaas.zones.zone import NO_ZONES, ZoneSet

MAP_JSON = "map.json"
"""File with the map as JSON of ``nav_msgs/OccupancyGrid``, ready to be sent."""

INDEX = ".index"
"""Suffix of a planner's index of the map, after the name of the planner."""

_INFO = "info.json"
_ZONES = "zones.geojson"


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
        The folder.
    layers : MapLayers
        The layers.
    created : float
        Time when the map was made [s since the epoch].

    Raises
    ------
    Unavailable
        The files cannot be written, for example because shared memory is full.
    """
    message = encode(to_message(layers.grid, stamp=Time.of(created)))
    info = layers.grid.info
    arrays = _arrays_of(layers)
    try:
        (folder / MAP_JSON).write_bytes(message)
        written = {name: _write(folder / f"{name}.npy", array) for name, array in arrays.items()}
        origin = (info.origin.x, info.origin.y, info.origin.theta)
        header = _Info(info.resolution, info.width, info.height, origin, written)
        if layers.zones.zones:
            (folder / _ZONES).write_bytes(geojson_of(layers.zones))
        (folder / _INFO).write_bytes(msgspec.json.encode(header))
    except OSError as error:  # numpy raises it without errno when the disk is full
        size = (len(message) + sum(array.nbytes for array in arrays.values())) / 2**20
        text = f"{size:.1f} MB of map layers cannot be written"
        raise Unavailable(
            f"{text} to {folder.parent}: {error}", public=f"{text} on its machine: {_reason(error)}"
        ) from error


def _arrays_of(layers: MapLayers) -> dict[str, NDArray[Any]]:
    arrays: dict[str, NDArray[Any]] = {
        "grid": layers.grid.data,
        "costmap": layers.costmap.data,
        "distance": layers.distance,
    }
    if layers.keepout is not None:
        arrays["keepout"] = layers.keepout.data
    if layers.barred_distance is not None:
        arrays["barred_distance"] = layers.barred_distance
    for name, mask in (("speed", layers.speed), ("overhead", layers.overhead)):
        if mask is not None:
            arrays[name] = mask.data
    return arrays


def _write(path: Path, array: NDArray[Any]) -> _Layer:
    np.save(path, np.ascontiguousarray(array), allow_pickle=False)
    return _Layer(array.dtype.str, path.stat().st_size - array.nbytes)


def open_layers(folder: Path) -> MapLayers:
    """Map the layers in a folder into memory, read-only and without a copy.

    Raises
    ------
    Unavailable
        The layers do not exist, or are incomplete.
    """
    try:
        header = from_json((folder / _INFO).read_bytes(), _Info)
        info = GridInfo(header.resolution, header.width, header.height, Pose2D(*header.origin))
        arrays = {name: _map_array(folder / f"{name}.npy", layer, info.shape) for name, layer in header.layers.items()}
        grids = {name: GridMap(arrays[name], info) for name in ("keepout", "speed", "overhead") if name in arrays}
        layers = MapLayers(
            GridMap(arrays["grid"], info),
            Costmap(arrays["costmap"], info),
            arrays["distance"],
            barred_distance=arrays.get("barred_distance"),
            zones=_zones_in(folder),
            **grids,
        )
    except (OSError, KeyError, ValueError, InvalidInput, msgspec.DecodeError) as error:
        raise Unavailable(f"no complete map layers in {folder}: {error}", public="no complete map layers") from error
    return with_causes(layers)


def _zones_in(folder: Path) -> ZoneSet:
    try:
        return zones_of((folder / _ZONES).read_bytes())
    except FileNotFoundError:
        return NO_ZONES


def changed_cells(before: Path, after: Path) -> list[Rectangle] | None:
    """Return rectangles that cover the cells in which two maps differ; None if their geometries differ.

    Parameters
    ----------
    before, after : Path
        Folders with layers.

    Raises
    ------
    Unavailable
        The layers do not exist, or are incomplete.
    """
    old, new = (open_layers(folder).grid for folder in (before, after))
    if old.info != new.info:
        return None
    return changed_rectangles(old.data, new.data, Rectangle(0, 0, *new.info.shape))


def cells_in(folder: Path) -> int:
    """Return the number of cells of the map in a folder of layers, or 0 if it has no layers."""
    try:
        header = from_json((folder / _INFO).read_bytes(), _Info)
    except (OSError, msgspec.DecodeError):
        return 0
    return header.width * header.height


def _map_array(path: Path, layer: _Layer, shape: tuple[int, int]) -> NDArray[Any]:
    # numpy's own loader parses the header as Python code, which takes each container 1 ms and 0.6 MB.
    with path.open("rb") as file:
        memory = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    return np.frombuffer(memory, layer.dtype, offset=layer.offset).reshape(shape)


def write_index(folder: Path, planner: str, content: memoryview) -> None:
    """Write the index of a planner into the folder of a map's layers, atomically.

    Raises
    ------
    Unavailable
        The file cannot be written, or the folder does not exist any more.
    """
    partial = folder / f".{planner}-{os.getpid()}"
    try:
        try:
            partial.write_bytes(content)
            partial.rename(folder / f"{planner}{INDEX}")
        finally:
            partial.unlink(missing_ok=True)
    except OSError as error:
        size = content.nbytes / 2**20
        text = f"an index of {size:.1f} MB cannot be written"
        raise Unavailable(f"{text} to {folder}: {error}", public=f"{text} on its machine: {_reason(error)}") from error


def open_index(folder: Path, planner: str) -> memoryview | None:
    """Map the index of a planner into memory, read-only; return None if it does not exist.

    Raises
    ------
    Unavailable
        The index cannot be read.
    """
    try:
        with (folder / f"{planner}{INDEX}").open("rb") as file:
            return memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise Unavailable(
            f"the index of planner {planner} in {folder} cannot be read: {error}",
            public=f"the index of planner {planner} cannot be read",
        ) from error


def _reason(error: OSError) -> str:
    """Return the reason of an error without a path; numpy's errors for a full disk have no number."""
    return error.strerror or "no space is left"
