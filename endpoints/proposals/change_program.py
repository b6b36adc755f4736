"""Program that finds the changes of a map that a robot has confirmed, and writes the files of the changed map."""

import json
import sys
from pathlib import Path
from typing import Any

from endpoints.proposals.compared_files import BEFORE, SETTINGS
from endpoints.rest.maps.map_programs import be_program
from ppaas.errors import QuotaExceeded
from ppaas.mapping.lifelong.changed_places import KnownChanges
from ppaas.mapping.lifelong.changes import confirmed_changes, later_frames
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.map_drawing import DrawingSettings, draw_map
from ppaas.mapping.serialization.mapping_file import unpack_mapping
from ppaas.maps.formats.map_files import open_grid, save_map
from ppaas.maps.grid import GridMap
from storage.staged_uploads import mapped
from storage.versions import IMAGE, POSEGRAPH, YAML


def find(folder: Path) -> dict[str, Any]:
    """Write YAML and image of the changed map into a folder, and return the changes.

    Parameters
    ----------
    folder : Path
        With the files of the map, the pose graph of the robot, and the settings: ``left``, ``new``, the centres of
        known changes [m], ``min_pass_through`` and ``occupancy_threshold``.

    Returns
    -------
    dict
        ``left`` and ``new``, lists of the fields of `ChangedPlace`; nothing is written if both are empty.

    Raises
    ------
    InvalidInput
        The robot does not continue this map.
    QuotaExceeded
        The grid would be too large.
    """
    settings = json.loads((folder / SETTINGS).read_bytes())
    rows = open_grid((folder / f"{BEFORE}{YAML}").read_bytes(), mapped(folder / f"{BEFORE}{IMAGE}"))
    before = GridMap(rows.rows(0, rows.info.height), rows.info)
    published = unpack_mapping(memoryview(mapped(folder / f"{BEFORE}{POSEGRAPH}"))).frames
    frames = unpack_mapping(memoryview(mapped(folder / POSEGRAPH))).frames
    later = later_frames(frames, published)
    drawing = DrawingSettings(rows.info.resolution, settings["min_pass_through"], settings["occupancy_threshold"])
    now, known = draw_map(frames, frames.poses, drawing), KnownChanges(settings["left"], settings["new"])
    found = confirmed_changes(before, now, later, LifelongParameters().pass_distance, known)
    if found.left or found.new:
        record, pixels = save_map(found.grid, "map.pgm")
        (folder / YAML).write_bytes(record)
        (folder / IMAGE).write_bytes(pixels)
    return {"left": found.left, "new": found.new}


if __name__ == "__main__":
    be_program(
        lambda: find(Path(sys.argv[1])),
        QuotaExceeded("the map is too large to be compared: choose a coarser resolution"),
    )
