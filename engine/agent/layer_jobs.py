"""Jobs that make the layers and indexes of a map, each in a process that is forked for it."""

import os
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from engine.protocols.robot_link import Refusal
from engine.runtimes.fork_server.child import die_with_parent
from engine.specs.containers import Heights, LayerSpec
from engine.specs.layer_files import open_layers, write_index, write_layers
from ppaas.errors import NotFound, PPaaSError
from ppaas.nodes.map_server.costmap_filters import KEEPOUT_FILTER, SPEED_FILTER
from storage.disk_errors import disk_errors
from storage.staged_uploads import mapped

if TYPE_CHECKING:
    from ppaas.maps.grid import GridInfo, GridMap

INDEX_NICENESS = 10
"""How much an index gives way: robots drive meanwhile."""


class GridFiles(msgspec.Struct, frozen=True):
    """Files of a map on this machine, of them an octomap where one is wanted, and its time [s since the epoch]."""

    yaml: str
    image: str
    created: float
    octomap: str = ""


def build_here(spec: LayerSpec, files: GridFiles, masks: Mapping[str, GridFiles], folder: Path) -> None:
    """Make the layers of a map and write them into a folder.

    Parameters
    ----------
    spec : LayerSpec
        What they are to be.
    files : GridFiles
        Of the map.
    masks : mapping of str to GridFiles
        Of its masks, by the names of the costmap filters.
    folder : Path
        Where to.

    Raises
    ------
    InvalidMap
        The files are no map, or those of a mask.
    Unavailable
        There is no room, or the files are gone.
    """
    # Loaded in the process that builds: numba is not for the agent.
    from ppaas.costmap.build_layers import build_layers  # noqa: PLC0415

    grid = _grid_of(files)
    laid = {name: _grid_of(own) for name, own in masks.items()}
    layers = build_layers(
        grid,
        robot_radius=spec.robot_radius,
        keepout=laid.get(KEEPOUT_FILTER),
        overhead=_overhead(files, grid.info, spec.heights),
        speed=laid.get(SPEED_FILTER),
    )
    write_layers(folder, layers, files.created)


def _overhead(files: GridFiles, info: "GridInfo", heights: Heights | None) -> "GridMap | None":
    if heights is None or not files.octomap:
        return None
    from ppaas.costmap.height_mask import height_mask  # noqa: PLC0415  # as above
    from ppaas.maps.octomap import parse_octomap  # noqa: PLC0415

    octomap = Path(files.octomap)
    with disk_errors(octomap):
        tree = parse_octomap(mapped(octomap))
    return height_mask(tree, info, lowest=heights[0], highest=heights[1])


def _grid_of(files: GridFiles) -> "GridMap":
    from ppaas.maps.formats.map_files import load_map  # noqa: PLC0415  # as above

    yaml, image = Path(files.yaml), Path(files.image)
    with disk_errors(image):
        return load_map(yaml.read_bytes(), mapped(image))


def index_here(folder: Path, planner: str) -> None:
    """Let a planner prepare the map of which a folder has the layers, and put what it made beside them.

    Raises
    ------
    NotFound
        No planner of that name makes an index that can be shared.
    InvalidPlanner
        It cannot prepare this map.
    Unavailable
        There is no room.
    """
    from ppaas.planners.hub_labels.planner import HubLabels  # noqa: PLC0415

    if planner != HubLabels.name:
        raise NotFound("index", planner, [HubLabels.name])
    os.nice(INDEX_NICENESS)
    threads = len(os.sched_getaffinity(0))
    index = HubLabels().prepare(open_layers(folder).costmap, threads=threads)
    write_index(folder, planner, index.words.data.cast("B"))


def make_and_tell(make: Callable[..., None], arguments: tuple[object, ...], answer: Connection) -> None:
    """Make something, and answer why it could not be made, or nothing; ends with the agent."""
    die_with_parent()
    try:
        make(*arguments)
    except PPaaSError as error:
        answer.send(Refusal(error.slug, str(error)))
    else:
        answer.send(None)
