"""Checks of the contents of map files, which read no more of them than necessary."""

import contextlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from endpoints.rest.maps.map_programs import CHECK_SECONDS, run_program
from ppaas.errors import InvalidMap
from ppaas.maps.formats.map_files import open_grid, read_info
from ppaas.maps.georeference import anchor_of
from ppaas.maps.grid import GridInfo
from ppaas.zones.gate import check_on_map
from ppaas.zones.reading import zones_of
from storage.staged_uploads import Buffer, StagedUpload
from storage.versions import IMAGE, OCTOMAP, POSEGRAPH, YAML, ZONES

if TYPE_CHECKING:
    from endpoints.rest.maps import part_check  # noqa: F401 - the program named below

_PART_CHECK = "endpoints.rest.maps.part_check"

_NO_GRID = {"resolution": None, "width": None, "height": None, "origin": None, "georeference": None}


def grid_of(buffers: Mapping[str, Buffer]) -> dict[str, Any]:
    """Return resolution, size, origin and georeference of the grid; all None if the map has none. Pixels are not read.

    Raises
    ------
    InvalidMap
        The files are not a valid grid.
    """
    if YAML not in buffers:
        return _NO_GRID
    record = bytes(buffers[YAML])
    answer = _grid_answer(read_info(record, buffers[IMAGE]))
    with contextlib.suppress(InvalidMap):  # map_server and Nav2 ignore the key: a map with a wrong one is usable
        answer["georeference"] = _georeference(record)
    return answer


def check_contents(upload: StagedUpload) -> dict[str, Any]:
    """Check that the uploaded files are valid map files; return the same as ``grid_of``, and `warnings`.

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
    record = bytes(upload.buffer(YAML))
    grid = open_grid(record, upload.buffer(IMAGE))
    grid.check()
    answer, warnings = _grid_answer(grid.info), list[str]()
    try:
        answer["georeference"] = _georeference(record)
    except InvalidMap as error:
        warnings.append(f"{error}; the map is kept without one")
    if ZONES in upload.files:
        warnings += check_on_map(zones_of(bytes(upload.buffer(ZONES))), grid.info)
    return answer | {"warnings": warnings}


def _grid_answer(info: GridInfo) -> dict[str, Any]:
    origin = list(info.origin)
    return _NO_GRID | {"resolution": info.resolution, "width": info.width, "height": info.height, "origin": origin}


def _georeference(record: bytes) -> list[float] | None:
    anchor = anchor_of(record)
    return None if anchor is None else [anchor.latitude, anchor.longitude, anchor.yaw]


def _check_part(upload: StagedUpload, part: str) -> None:
    """Parse a file in a separate process; raises as ``check_contents`` does."""
    run_program(_PART_CHECK, [part, str(upload.path(part))], f"the {part} could not be checked", CHECK_SECONDS)
