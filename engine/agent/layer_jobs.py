"""Jobs that make the layers and indexes of a map; each runs in its own forked process."""

import os
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from engine.protocols.refusals import refusal_of
from engine.runtimes.fork_server.child import die_with_parent
from engine.specs.containers import Heights, LayerSpec
from engine.specs.layer_files import open_layers, write_index, write_layers
from ppaas.errors import NotFound, PPaaSError
from ppaas.nodes.map_server.costmap_filters import KEEPOUT_FILTER, SPEED_FILTER
from storage.staged_uploads import mapped
from storage.store_errors import disk_errors

if TYPE_CHECKING:
    from ppaas.maps.grid import GridInfo, GridMap

INDEX_NICENESS = 10
"""Niceness of a process that makes an index: containers of driving robots have precedence."""


class GridFiles(msgspec.Struct, frozen=True):
    """Paths of a map's files on this machine, and its time of creation [s since the epoch].

    ``octomap`` is empty if the layers need none, and ``zones`` if the map has none.
    """

    yaml: str
    image: str
    created: float
    octomap: str = ""
    zones: str = ""


def build_here(spec: LayerSpec, files: GridFiles, masks: Mapping[str, GridFiles], folder: Path) -> None:
    """Make the layers of a map and write them into a folder.

    Parameters
    ----------
    spec : LayerSpec
        Robot radius, masks, heights and costs of the layers.
    files : GridFiles
        Files of the map.
    masks : mapping of str to GridFiles
        Files of its masks, by the names of the costmap filters.
    folder : Path
        Folder to write to.

    Raises
    ------
    InvalidMap
        The files of the map or of a mask are not valid.
    Unavailable
        There is no space, or a file cannot be read.
    """
    # Imported in the forked process only: the agent must not load numba.
    from ppaas.costmap.build_layers import build_layers  # noqa: PLC0415
    from ppaas.zones.reading import zones_of  # noqa: PLC0415
    from ppaas.zones.zone import NO_ZONES  # noqa: PLC0415

    grid = _grid_of(files)
    laid = {name: _grid_of(own) for name, own in masks.items()}
    layers = build_layers(
        grid,
        robot_radius=spec.robot_radius,
        keepout=laid.get(KEEPOUT_FILTER),
        overhead=_overhead(files, grid.info, spec.heights),
        speed=laid.get(SPEED_FILTER),
        inflation_radius=spec.costs.inflation_radius,
        cost_scaling_factor=spec.costs.cost_scaling_factor,
        lethal_cost_threshold=spec.costs.lethal_cost_threshold,
        zones=zones_of(Path(files.zones).read_bytes()) if files.zones else NO_ZONES,
    )
    write_layers(folder, layers, files.created)


def _overhead(files: GridFiles, info: "GridInfo", heights: Heights | None) -> "GridMap | None":
    if heights is None or not files.octomap:
        return None
    from ppaas.costmap.filter_masks import height_mask  # noqa: PLC0415  # as above
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
    """Make a planner's index of the map whose layers are in a folder, and write it to that folder.

    Raises
    ------
    NotFound
        No planner of that name makes an index that can be shared.
    InvalidPlanner
        The planner cannot prepare this map.
    Unavailable
        There is no space.
    """
    from ppaas.planners.hub_labels.planner import HubLabels  # noqa: PLC0415

    if planner != HubLabels.name:
        raise NotFound("index", planner, [HubLabels.name])
    os.nice(INDEX_NICENESS)
    threads = len(os.sched_getaffinity(0))
    index = HubLabels().prepare(open_layers(folder).costmap, threads=threads)
    write_index(folder, planner, index.words.data.cast("B"))


def make_and_tell(make: Callable[..., None], arguments: tuple[object, ...], answer: Connection) -> None:
    """Run a job, and send its refusal, or None on success; the process is killed when the agent exits."""
    die_with_parent()
    try:
        make(*arguments)
    except PPaaSError as error:
        answer.send(refusal_of(error))
    else:
        answer.send(None)
