"""Checks of the contents of map files, which read no more of them than necessary."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from endpoints.rest.maps.map_programs import CHECK_SECONDS, run_program
from ppaas.maps.formats.map_files import open_grid, read_info
from ppaas.maps.grid import GridInfo
from ppaas.zones.gate import check_on_map
from ppaas.zones.reading import zones_of
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
    """Check that the uploaded files are valid map files; return the same as ``grid_of``, and `warnings` on zones.

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
        return _grid_answer(grid.info) | {"warnings": check_on_map(zones_of(bytes(upload.buffer(ZONES))), grid.info)}
    return _grid_answer(grid.info)


def _grid_answer(info: GridInfo) -> dict[str, Any]:
    return {"resolution": info.resolution, "width": info.width, "height": info.height, "origin": list(info.origin)}


def _check_part(upload: StagedUpload, part: str) -> None:
    """Parse a file in a separate process; raises as ``check_contents`` does."""
    run_program(_PART_CHECK, [part, str(upload.path(part))], f"the {part} could not be checked", CHECK_SECONDS)
