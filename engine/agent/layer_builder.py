"""Makes layers and indexes of a map in a process of its own: warm from the first call, alone if memory runs out."""

import asyncio
import multiprocessing
import os
from collections.abc import Callable, Collection, Mapping
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection
from multiprocessing.popen_forkserver import Popen
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from engine.protocols.robot_link import Refusal
from engine.runtimes.fork_server.child import die_with_parent
from engine.runtimes.fork_server.server import UNHEARD, fork
from engine.specs.containers import Heights, LayerSpec, MapVersion
from engine.specs.filter_masks import no_grid_in, no_mask
from engine.specs.layer_files import open_layers, write_index, write_layers
from ppaas.errors import InvalidMap, NotFound, PPaaSError, Unavailable, rebuild
from ppaas.nodes.map_server.costmap_filters import KEEPOUT_FILTER, SPEED_FILTER
from storage.disk_errors import disk_errors
from storage.opened_maps import no_grid
from storage.ports import MapStore
from storage.staged_uploads import mapped
from storage.versions import IMAGE, OCTOMAP, YAML

if TYPE_CHECKING:
    from ppaas.maps.grid import GridInfo, GridMap

INDEX_NICENESS = 10
"""How much an index gives way: robots drive meanwhile."""

ENDING = 1.0
"""Seconds that a process which has answered may take to end."""


class GridFiles(msgspec.Struct, frozen=True):
    """Files of a map on this machine, of them an octomap where one is wanted, and its time [s since the epoch]."""

    yaml: str
    image: str
    created: float
    octomap: str = ""


class LayerBuilder:
    """Makes the layers of maps that a store keeps.

    Parameters
    ----------
    maps : MapStore
        Which one.
    """

    def __init__(self, maps: MapStore) -> None:
        self._maps = maps

    async def __call__(self, spec: LayerSpec, folder: Path) -> None:
        """Make the layers of a map in a process forked from the fork server.

        Raises
        ------
        NotFound
            The map is gone.
        InvalidParameter
            A mask is gone, or no grid.
        InvalidMap
            The map is no grid.
        Unavailable
            Its store is away, there is no room, or the process was killed.
        """
        with ExitStack() as stack:
            parts = (YAML, IMAGE) if spec.heights is None else (YAML, IMAGE, OCTOMAP)
            files = await self._opened(stack, spec.map, parts)
            masks = {name: await self._opened_mask(stack, name, mask) for name, mask in spec.masks.items()}
            await build_in_fork(spec, files, masks, folder)

    async def _opened(self, stack: ExitStack, version: MapVersion, parts: Collection[str] = (YAML, IMAGE)) -> GridFiles:
        opening = self._maps.open_map(version.id, version.version, only=parts)
        opened = await asyncio.to_thread(stack.enter_context, opening)
        if YAML not in opened.paths:
            raise no_grid(opened.record)
        paths = {part: str(path) for part, path in opened.paths.items()}
        return GridFiles(paths[YAML], paths[IMAGE], opened.record.created, paths.get(OCTOMAP, ""))

    async def _opened_mask(self, stack: ExitStack, name: str, mask: MapVersion) -> GridFiles:
        try:
            return await self._opened(stack, mask)
        except NotFound as error:
            raise no_mask(name, mask.id) from error
        except InvalidMap as error:
            raise no_grid_in(name, mask.id) from error


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
    from ppaas.costmap.height_mask import in_the_way  # noqa: PLC0415  # as above
    from ppaas.maps.octomap import parse_octomap  # noqa: PLC0415

    octomap = Path(files.octomap)
    with disk_errors(octomap):
        tree = parse_octomap(mapped(octomap))
    return in_the_way(tree, info, lowest=heights[0], highest=heights[1])


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


async def index_in_fork(folder: Path, planner: str) -> None:
    """Let a planner prepare a map, as ``index_here`` does, in a process forked from the fork server.

    Raises
    ------
    NotFound, InvalidPlanner
    Unavailable
        There is no room, or the process was killed.
    """
    await _in_fork(f"the index of {planner}", index_here, folder, planner)


async def build_in_fork(spec: LayerSpec, files: GridFiles, masks: Mapping[str, GridFiles], folder: Path) -> None:
    """Make the layers of a map, as ``build_here`` does, in a process forked from the fork server.

    Raises
    ------
    InvalidMap
    Unavailable
        There is no room, the files are gone, or the process was killed.
    """
    await _in_fork(f"the layers of map {spec.map.id!r}", build_here, spec, files, masks, folder)


async def _in_fork(what: str, make: Callable[..., None], *arguments: object) -> None:
    receiving, sending = multiprocessing.Pipe(duplex=False)
    with receiving, sending:
        try:
            process = await fork(_make_and_tell, make, arguments, sending)
            sending.close()
            answer = await asyncio.to_thread(_answer_of, process, receiving)
        except (EOFError, OSError) as error:
            raise Unavailable(f"the process that made {what} was lost; try again") from error
    if answer is not None:
        raise rebuild(answer.slug, answer.text)


def _answer_of(process: Popen, receiving: Connection) -> Refusal | None:
    answer: Refusal | None = receiving.recv()
    status = process.wait(ENDING)  # a fork server that is frozen tells nothing of it
    process.close()
    if status == UNHEARD:  # the fork server died meanwhile, and left the process to us
        with suppress(ChildProcessError):
            os.waitpid(process.pid, 0)
    return answer


def _make_and_tell(make: Callable[..., None], arguments: tuple[object, ...], answer: Connection) -> None:
    die_with_parent()
    try:
        make(*arguments)
    except PPaaSError as error:
        answer.send(Refusal(error.slug, str(error)))
    else:
        answer.send(None)
