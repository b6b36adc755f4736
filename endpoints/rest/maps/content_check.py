"""Checks of the contents of map files, which read no more of them than necessary."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from endpoints.rest.maps.map_programs import CHECK_SECONDS, run_program
from ppaas.errors import InvalidZones
from ppaas.maps.formats.map_files import open_grid, read_info
from ppaas.maps.grid import GridInfo
from ppaas.zones.shapes import Area
from ppaas.zones.zone import ZoneSet, zones_of
from storage.staged_uploads import Buffer, StagedUpload
from storage.versions import IMAGE, OCTOMAP, POSEGRAPH, YAML, ZONES

if TYPE_CHECKING:
    from endpoints.rest.maps import part_check  # noqa: F401 - the program named below

_PART_CHECK = "endpoints.rest.maps.part_check"

_NO_GRID = {"resolution": None, "width": None, "height": None, "origin": None}


def grid_of(buffers: Mapping[str, Buffer]) -> dict[str, Any]:
    """Return resolution, size and origin of the grid; all are None if the map has no grid. Pixels are not read.

    Raises
    ------
    InvalidMap
        The files are not a valid grid.
    """
    return _grid_answer(read_info(bytes(buffers[YAML]), buffers[IMAGE])) if YAML in buffers else _NO_GRID


def check_contents(upload: StagedUpload) -> dict[str, Any]:
    """Check that the uploaded files are valid map files; return the same as ``grid_of``.

    Raises
    ------
    InvalidMap
        A file is not valid; the message says why.
    InvalidZones
        A zone is not on the map.
    Unavailable
        The check of an octree or a pose graph ran out of memory or time, or crashed.
    """
    for part in (OCTOMAP, POSEGRAPH):
        if part in upload.files:
            _check_part(upload, part)
    if YAML not in upload.files:
        return _NO_GRID
    grid = open_grid(bytes(upload.buffer(YAML)), upload.buffer(IMAGE))
    grid.check()
    if ZONES in upload.files:
        check_zones(zones_of(bytes(upload.buffer(ZONES))), grid.info)
    return _grid_answer(grid.info)


def check_zones(zones: ZoneSet, info: GridInfo) -> None:
    """Raise ``InvalidZones`` if the box around a zone is all outside of a grid."""
    for zone in zones.zones:
        area = zone.area
        corners = info.to_cells([(x, y) for x in (area.low[0], area.high[0]) for y in (area.low[1], area.high[1])])
        if (corners.max(axis=0) < 0).any() or (corners.min(axis=0) >= info.shape).any():
            raise InvalidZones(
                f"zone {zone.name!r} is not on the map: it is at {_range(area, 0)} × {_range(area, 1)}; are its "
                "positions longitudes and latitudes? They must be x, y in metres in the frame of the map"
            )


def _range(area: Area, axis: int) -> str:
    return f"{area.low[axis]:.6g} to {area.high[axis]:.6g} m"


def _grid_answer(info: GridInfo) -> dict[str, Any]:
    return {"resolution": info.resolution, "width": info.width, "height": info.height, "origin": list(info.origin)}


def _check_part(upload: StagedUpload, part: str) -> None:
    """Parse a file in a process of its own; raises as ``check_contents`` does."""
    run_program(_PART_CHECK, [part, str(upload.path(part))], f"the {part} could not be checked", CHECK_SECONDS)
