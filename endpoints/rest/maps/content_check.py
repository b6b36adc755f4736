"""What is in the files of a map, looked at without reading more of them than must be."""

import json
import subprocess
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidMap, Unavailable
from ppaas.maps.formats.map_files import GridRows, open_grid
from storage.staged_uploads import Buffer, StagedUpload
from storage.versions import IMAGE, OCTOMAP, YAML

if TYPE_CHECKING:
    from endpoints.rest.maps import octomap_check  # noqa: F401 - the program that is named below

_OCTOMAP_CHECK = ("-m", "endpoints.rest.maps.octomap_check")
_NO_GRID = {"resolution": None, "width": None, "height": None, "origin": None}


def grid_of(buffers: Mapping[str, Buffer]) -> dict[str, Any]:
    """Return the size of a grid and where it lies; all of it None if there is none.

    Raises
    ------
    InvalidMap
        The files are no grid.
    """
    return _told(open_grid(bytes(buffers[YAML]), buffers[IMAGE])) if YAML in buffers else _NO_GRID


def check_contents(draft: StagedUpload) -> dict[str, Any]:
    """Make sure that files are those of a map; return what ``grid_of`` does.

    Raises
    ------
    InvalidMap
        A file is not what it says; the text tells what is wrong.
    Unavailable
        There is no room to look at it.
    """
    if OCTOMAP in draft.files:
        _check_octomap(draft)
    if YAML not in draft.files:
        return _NO_GRID
    grid = open_grid(bytes(draft.buffer(YAML)), draft.buffer(IMAGE))
    grid.check()
    return _told(grid)


def _told(grid: GridRows) -> dict[str, Any]:
    info = grid.info
    return {"resolution": info.resolution, "width": info.width, "height": info.height, "origin": list(info.origin)}


def _check_octomap(draft: StagedUpload) -> None:
    """Read an octree in a process of its own: its kernels take long to load, and a bad file may want much memory."""
    command = [sys.executable, *_OCTOMAP_CHECK, str(draft.path(OCTOMAP))]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    if ended.returncode:
        raise Unavailable(
            f"the octomap could not be looked at ({ended.returncode}): it may be too large for this machine"
        )
    fault = json.loads(ended.stdout)["fault"]
    if fault:
        raise InvalidMap(fault)
