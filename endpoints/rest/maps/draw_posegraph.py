"""Program that refines a pose graph and draws its grid."""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from endpoints.rest.maps.map_programs import be_program
from ppaas.errors import InvalidGraph, InvalidMap, QuotaExceeded
from ppaas.mapping.closures.agreement import GRADUATED
from ppaas.mapping.graph.pose_graph import EdgeKind
from ppaas.mapping.graph.solver import GraphSolver
from ppaas.mapping.map_drawing import DrawingSettings, draw_map
from ppaas.mapping.refinement import refine
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.maps.formats.map_files import save_map
from storage.staged_uploads import mapped
from storage.versions import IMAGE, POSEGRAPH, YAML


def draw(folder: Path, settings: dict[str, Any]) -> None:
    """Write YAML and image of the pose graph in a folder beside it, and the refined pose graph in its place.

    Parameters
    ----------
    folder : Path
        With the file of the pose graph, named as the part of a map.
    settings : dict
        ``refine``: whether all scans are aligned with each other first; and the fields of `DrawingSettings`.

    Raises
    ------
    InvalidMap
        The pose graph cannot be read.
    QuotaExceeded
        The grid would be too large.
    """
    mapping = _read(folder / POSEGRAPH)
    if settings.pop("refine"):
        _refine(mapping)
    grid = draw_map(mapping.frames, mapping.frames.poses, DrawingSettings(**settings))
    record, pixels = save_map(grid, "map.pgm")
    (folder / YAML).write_bytes(record)
    (folder / IMAGE).write_bytes(pixels)
    (folder / f"{POSEGRAPH}.new").write_bytes(b"".join(pack_mapping(mapping)))
    (folder / f"{POSEGRAPH}.new").replace(folder / POSEGRAPH)


def _read(path: Path) -> Mapping:
    try:
        return unpack_mapping(memoryview(mapped(path)))
    except InvalidGraph as error:
        raise InvalidMap(str(error)) from error


def _refine(mapping: Mapping) -> None:
    """Solve the graph, and align all scans that overlap, as at the end of a recorded drive."""
    solved = GraphSolver().solve(mapping.graph, GRADUATED)
    edges = mapping.graph.edges
    odometry = edges.take(np.asarray(edges.kinds == EdgeKind.ODOMETRY))
    poses = refine(mapping.frames, solved.poses, odometry).poses
    mapping.frames.poses[:] = poses
    mapping.graph.move_nodes(poses)


if __name__ == "__main__":
    be_program(
        lambda: draw(Path(sys.argv[1]), json.loads(sys.argv[2])),
        QuotaExceeded("the map is too large to be drawn: choose a coarser resolution"),
    )
