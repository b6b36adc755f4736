"""Program that refines a pose graph and draws its grid; it writes the error, if any, to standard output as JSON."""

import json
import resource
import sys
from pathlib import Path
from typing import Any

import numpy as np

from endpoints.rest.maps.part_check import MEMORY
from ppaas.errors import PPaaSError
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
    InvalidGraph
        The pose graph cannot be read.
    QuotaExceeded
        The grid would be too large.
    """
    mapping = unpack_mapping(memoryview(mapped(folder / POSEGRAPH)))
    if settings.pop("refine"):
        _refine(mapping)
    grid = draw_map(mapping.frames, mapping.frames.poses, DrawingSettings(**settings))
    record, pixels = save_map(grid, "map.pgm")
    (folder / YAML).write_bytes(record)
    (folder / IMAGE).write_bytes(pixels)
    (folder / f"{POSEGRAPH}.new").write_bytes(b"".join(pack_mapping(mapping)))
    (folder / f"{POSEGRAPH}.new").replace(folder / POSEGRAPH)


def _refine(mapping: Mapping) -> None:
    """Solve the graph, and align all scans that overlap, as at the end of a recorded drive."""
    solved = GraphSolver().solve(mapping.graph, GRADUATED)
    edges = mapping.graph.edges
    odometry = edges.take(np.asarray(edges.kinds == EdgeKind.ODOMETRY))
    poses = refine(mapping.frames, solved.poses, odometry).poses
    mapping.frames.poses[:] = poses
    mapping.graph.move_nodes(poses)


def fault_of(folder: Path, settings: dict[str, Any]) -> str:
    """Draw; return the error, or an empty text."""
    try:
        draw(folder, settings)
    except PPaaSError as error:
        return str(error)
    except MemoryError:
        return "the map is too large to be drawn: choose a coarser resolution"
    return ""


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    sys.stdout.write(json.dumps({"fault": fault_of(Path(sys.argv[1]), json.loads(sys.argv[2]))}))
