"""Makes layers and indexes of a map in a process of its own: warm from the first call, alone if memory runs out."""

import asyncio
import multiprocessing
import os
from collections.abc import Callable
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection
from pathlib import Path

import msgspec

from engine.layer_files import open_layers, write_index, write_layers
from engine.link import Refusal
from engine.model import MapVersion
from engine.runtimes.child import die_with_parent
from engine.runtimes.fork_server import UNHEARD, start_process
from ppaas.errors import NotFound, PPaaSError, Unavailable, rebuild
from storage.drafts import mapped
from storage.failures import disk_errors
from storage.opened import no_grid
from storage.ports import MapStore
from storage.versions import IMAGE, YAML

INDEX_NICENESS = 10
"""How much an index gives way: robots drive meanwhile."""


class GridFiles(msgspec.Struct, frozen=True):
    """The files of a grid on this machine, and when it was published [s since the epoch]."""

    yaml: str
    image: str
    created: float


class LayerBuilder:
    """Makes the layers of maps that a store keeps.

    Parameters
    ----------
    maps : MapStore
        Which one.
    """

    def __init__(self, maps: MapStore) -> None:
        self._maps = maps

    async def __call__(self, version: MapVersion, robot_radius: float, folder: Path) -> None:
        """Make the layers of a map in a process forked from the fork server.

        Raises
        ------
        NotFound
            The map is gone.
        InvalidMap
            It is no grid.
        Unavailable
            Its store is away, there is no room, or the process was killed.
        """
        with ExitStack() as stack:
            opening = self._maps.open_map(version.id, version.version, only=(YAML, IMAGE))
            opened = await asyncio.to_thread(stack.enter_context, opening)
            if YAML not in opened.paths:
                raise no_grid(opened.record)
            paths = str(opened.paths[YAML]), str(opened.paths[IMAGE])
            await build_in_fork(version.id, GridFiles(*paths, opened.record.created), robot_radius, folder)


def build_here(files: GridFiles, robot_radius: float, folder: Path) -> None:
    """Make the layers of a map and write them into a folder.

    Raises
    ------
    InvalidMap
        The files are no map.
    Unavailable
        There is no room, or the files are gone.
    """
    # Loaded in the process that builds: numba is not for the agent.
    from ppaas.costmap.build import build_layers  # noqa: PLC0415
    from ppaas.maps.files import load_map  # noqa: PLC0415

    yaml, image = Path(files.yaml), Path(files.image)
    with disk_errors(image):
        grid = load_map(yaml.read_bytes(), mapped(image))
    write_layers(folder, build_layers(grid, robot_radius=robot_radius), files.created)


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


async def build_in_fork(map_id: str, files: GridFiles, robot_radius: float, folder: Path) -> None:
    """Make the layers of a map, as ``build_here`` does, in a process forked from the fork server.

    Raises
    ------
    InvalidMap
    Unavailable
        There is no room, the files are gone, or the process was killed.
    """
    await _in_fork(f"the layers of map {map_id!r}", build_here, files, robot_radius, folder)


async def _in_fork(what: str, make: Callable[..., None], *arguments: object) -> None:
    refusal = await asyncio.to_thread(_await_child, what, make, arguments)
    if refusal is not None:
        raise rebuild(refusal.slug, refusal.text)


def _await_child(what: str, make: Callable[..., None], arguments: tuple[object, ...]) -> Refusal | None:
    receiving, sending = multiprocessing.Pipe(duplex=False)
    with receiving, sending:
        try:
            process = start_process(_make_and_tell, make, arguments, sending)
            sending.close()
            answer: Refusal | None = receiving.recv()
        except (EOFError, OSError) as error:
            raise Unavailable(f"the process that made {what} was lost; try again") from error
        status = process.wait()
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
