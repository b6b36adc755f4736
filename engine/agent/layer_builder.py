"""Makes layers and indexes of a map in a process of its own: warm from the first call, alone if memory runs out."""

import asyncio
import multiprocessing
import os
from collections.abc import Callable, Collection, Mapping
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection
from multiprocessing.popen_forkserver import Popen
from pathlib import Path

from engine.agent.layer_jobs import GridFiles, build_here, index_here, make_and_tell
from engine.protocols.robot_link import Refusal
from engine.runtimes.fork_server.server import UNKNOWN_STATUS, fork
from engine.specs.containers import LayerSpec, MapVersion
from engine.specs.filter_masks import no_grid_in, no_mask
from ppaas.errors import InvalidMap, NotFound, Unavailable, rebuild
from storage.opened_maps import no_grid
from storage.ports import MapStore
from storage.versions import IMAGE, OCTOMAP, YAML

ENDING = 1.0
"""Seconds that a process which has answered may take to end."""


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
            process = await fork(make_and_tell, make, arguments, sending)
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
    if status == UNKNOWN_STATUS:  # the fork server died meanwhile, and left the process to us
        with suppress(ChildProcessError):
            os.waitpid(process.pid, 0)
    return answer
