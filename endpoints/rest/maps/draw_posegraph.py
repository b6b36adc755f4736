"""Program that finishes a pose graph and draws its grid."""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from endpoints.resources.publications import ProgressFile, Stage
from endpoints.rest.maps.map_programs import be_program
from ppaas.errors import InvalidGraph, InvalidMap, QuotaExceeded
from ppaas.mapping.map_drawing import DrawingSettings, draw_map
from ppaas.mapping.pipeline.graph_mapper import CLOSURES, finish_mapping
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.maps.formats.map_files import save_map
from ppaas.planar_poses import PoseArray, compose
from storage.staged_uploads import mapped
from storage.versions import IMAGE, POSEGRAPH, YAML


def draw(folder: Path, settings: dict[str, Any]) -> dict[str, list[float]]:
    """Write YAML and image of the pose graph in a folder beside it, and the refined pose graph in its place.

    Returns
    -------
    dict
        ``before``, ``after``: poses of the robot at the key frames, x, y [m], theta [rad] one after the other; empty
        without ``refine``.

    Parameters
    ----------
    folder : Path
        With the file of the pose graph, named as the part of a map.
    settings : dict
        ``refine``: whether the mapping is finished first, as at the end of a recorded drive; ``do_loop_closing``:
        whether missing loops are closed then; and the fields of `DrawingSettings`.

    Raises
    ------
    InvalidMap
        The pose graph cannot be read.
    QuotaExceeded
        The grid would be too large.
    """
    mapping, progress = _read(folder / POSEGRAPH), ProgressFile(folder)
    before = mapping.frames.poses.copy()
    refines, closes = settings.pop("refine"), settings.pop("do_loop_closing")
    if refines:
        closures = CLOSURES if closes else None
        mapping = finish_mapping(mapping, closures, lambda part, done: progress.write(Stage(part), done))
    progress.write(Stage.DRAWING)
    grid = draw_map(mapping.frames, mapping.frames.poses, DrawingSettings(**settings))
    record, pixels = save_map(grid, "map.pgm")
    (folder / YAML).write_bytes(record)
    (folder / IMAGE).write_bytes(pixels)
    (folder / f"{POSEGRAPH}.new").write_bytes(b"".join(pack_mapping(mapping)))
    (folder / f"{POSEGRAPH}.new").replace(folder / POSEGRAPH)
    return _motion(mapping, before) if refines else {"before": [], "after": []}


def _motion(mapping: Mapping, before: PoseArray) -> dict[str, list[float]]:
    robot = np.array(mapping.frames.geometry.mount.inverse())
    poses = {"before": compose(before, robot), "after": compose(mapping.frames.poses, robot)}
    return {name: of.ravel().tolist() for name, of in poses.items()}


def _read(path: Path) -> Mapping:
    try:
        return unpack_mapping(memoryview(mapped(path)))
    except InvalidGraph as error:
        raise InvalidMap(str(error)) from error


if __name__ == "__main__":
    be_program(
        lambda: draw(Path(sys.argv[1]), json.loads(sys.argv[2])),
        QuotaExceeded("the map is too large to be drawn: choose a coarser resolution"),
    )
