"""``ppaas slam LOG --floors FOLDER``: a map of each floor of a drive, and the building that they make."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.buildings.building import json_of
from ppaas.errors import InvalidInput
from ppaas.mapping.floors.floor_logs import FloorMap, floor_logs, surveyed_building
from ppaas.mapping.floors.levels import levels_of
from ppaas.maps.formats.map_files import save_map
from robots.cli.output_files import write_file
from robots.recordings.bag_heights import heights_of

if TYPE_CHECKING:
    from ppaas.mapping.pipeline.offline import LogMap
    from ppaas.mapping.scan_log import ScanLog

BUILDING = "building.json"


def check_floors(folder: Path) -> None:
    """Raise ``InvalidInput`` if maps of floors cannot be written to a folder, which is made if it is not there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(f"cannot write to folder {str(folder)!r}: {error.strerror}") from error


def map_floors(
    path: Path,
    log: "ScanLog",
    folder: Path,
    topic: str | None,
    *,
    mapped: Callable[["ScanLog", str], "LogMap"],
    resolution: float,
) -> list[dict[str, Any]]:
    """Write the map of each floor, and the building; return what is known of each floor.

    Parameters
    ----------
    path : Path
        The bag.
    log : ScanLog
        Its scans.
    folder : Path
        Folder for the files.
    topic : str, optional
        Topic with the heights.
    mapped : callable
        Maps a log; the second argument is its name.
    resolution : float
        Edge of a cell [m].

    Raises
    ------
    InvalidInput
        The bag has no heights, or no scan on any floor.
    """
    heights = heights_of(path, topic)
    floors = floor_logs(log, levels_of(heights.stamps, heights.heights))
    maps = [FloorMap(floor, mapped(floor.log, f"floor {floor.name}")) for floor in floors]
    stem = re.sub(r"[^A-Za-z0-9_-]+", "-", folder.resolve().name).strip("-") or "building"
    building = surveyed_building(maps, log, lambda name: f"{stem}-{name}")
    rows = []
    for each, floor in zip(maps, building.floors, strict=True):
        record, pixels = save_map(each.made.grid(resolution), f"{floor.map}.pgm")
        write_file(folder / f"{floor.map}.pgm", pixels)
        write_file(folder / f"{floor.map}.yaml", record)
        rows.append({"floor": floor.name, "map": floor.map, "elevation": floor.elevation} | each.made.summary())
    write_file(folder / BUILDING, json_of(building))
    return rows
