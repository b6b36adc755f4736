"""Layer builder: makes layers and indexes of a map in a forked process.

The process is forked from the warm fork server, so nothing has to be imported. If memory runs out, only it is killed.
"""

import asyncio
import multiprocessing
import os
import shutil
from collections.abc import Callable, Collection, Mapping
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection
from multiprocessing.popen_forkserver import Popen
from pathlib import Path

from engine.agent.layer_jobs import GridFiles, build_here, index_here, make_and_tell
from engine.protocols.refusals import Refusal, error_of
from engine.runtimes.fork_server.server import UNKNOWN_STATUS, fork
from engine.specs.containers import LayerSpec, MapVersion
from engine.specs.robot_maps import no_grid_in, no_mask
from ppaas.errors import InvalidMap, NotFound, Unavailable
from storage.map_port import no_grid
from storage.ports import MapStore
from storage.store_errors import disk_errors
from storage.versions import IMAGE, OCTOMAP, POSEGRAPH, YAML, ZONES

ENDING = 1.0
"""Time limit of a process to exit after its answer [s]."""


class LayerBuilder:
    """Builder of layers for the maps of a store.

    Parameters
    ----------
    maps : MapStore
        Store of the maps.
    """

    def __init__(self, maps: MapStore) -> None:
        self._maps = maps

    async def __call__(self, spec: LayerSpec, folder: Path) -> None:
        """Make the layers of a map in a process forked from the fork server.

        Raises
        ------
        NotFound
            The map does not exist.
        InvalidParameter
            A mask does not exist, or is not a grid.
        InvalidMap
            The map is not a grid.
        Unavailable
            The store is unavailable, there is no space, or the process was killed.
        """
        if spec.posegraph:
            await asyncio.to_thread(self._copy_posegraph, spec.map, folder)
            return
        with ExitStack() as stack:
            parts = (YAML, IMAGE, ZONES) if spec.heights is None else (YAML, IMAGE, ZONES, OCTOMAP)
            files = await self._opened(stack, spec.map, parts)
            masks = {name: await self._opened_mask(stack, name, mask) for name, mask in spec.masks.items()}
            await build_in_fork(spec, files, masks, folder)

    def _copy_posegraph(self, version: MapVersion, folder: Path) -> None:
        with self._maps.open_map(version.id, version.version, only=(POSEGRAPH,)) as opened:
            if POSEGRAPH not in opened.paths:
                raise NotFound(f"file of map {version.id!r}:", POSEGRAPH)
            with disk_errors(folder):
                shutil.copyfile(opened.paths[POSEGRAPH], folder / POSEGRAPH)

    async def _opened(self, stack: ExitStack, version: MapVersion, parts: Collection[str] = (YAML, IMAGE)) -> GridFiles:
        opening = self._maps.open_map(version.id, version.version, only=parts)
        opened = await asyncio.to_thread(stack.enter_context, opening)
        if YAML not in opened.paths:
            raise no_grid(opened.record)
        paths = {part: str(path) for part, path in opened.paths.items()}
        more = paths.get(OCTOMAP, ""), paths.get(ZONES, "")
        return GridFiles(paths[YAML], paths[IMAGE], opened.record.created, *more)

    async def _opened_mask(self, stack: ExitStack, name: str, mask: MapVersion) -> GridFiles:
        try:
            return await self._opened(stack, mask)
        except NotFound as error:
            raise no_mask(name, mask.id) from error
        except InvalidMap as error:
            raise no_grid_in(name, mask.id) from error


async def index_in_fork(folder: Path, planner: str) -> None:
    """Make a planner's index of a map, as ``index_here`` does, in a process forked from the fork server.

    Raises
    ------
    NotFound
        No planner of that name makes an index that can be shared.
    InvalidPlanner
        The planner cannot prepare this map.
    Unavailable
        There is no space, or the process was killed.
    """
    await _in_fork(f"the index of {planner}", index_here, folder, planner)


async def build_in_fork(spec: LayerSpec, files: GridFiles, masks: Mapping[str, GridFiles], folder: Path) -> None:
    """Make the layers of a map, as ``build_here`` does, in a process forked from the fork server.

    Raises
    ------
    InvalidMap
        The files of the map or of a mask are not valid.
    Unavailable
        There is no space, a file cannot be read, or the process was killed.
    """
    await _in_fork(f"the layers of map {spec.map.id!r}", build_here, spec, files, masks, folder)


async def _in_fork(what: str, make: Callable[..., None], *arguments: object) -> None:
    receiving, sending = multiprocessing.Pipe(duplex=False)
    with receiving, sending:
        try:
            process = await fork(make_and_tell, make, arguments, sending)
            sending.close()
            answer = await asyncio.to_thread(_answer_of, process, receiving)
        except (EOFError, OSError) as error:
            raise Unavailable(
                f"the process that makes {what} exited without an answer, perhaps out of memory; try again"
            ) from error
    if answer is not None:
        raise error_of(answer)


def _answer_of(process: Popen, receiving: Connection) -> Refusal | None:
    answer: Refusal | None = receiving.recv()
    status = process.wait(ENDING)  # with a limit: a frozen fork server reports no exit
    process.close()
    if status == UNKNOWN_STATUS:  # the fork server died, so this process is the parent now
        with suppress(ChildProcessError):
            os.waitpid(process.pid, 0)
    return answer
