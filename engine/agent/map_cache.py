"""The maps of a machine: the layers of each map version and robot, made once and shared by all containers."""

import asyncio
import hashlib
import os
import secrets
import shutil
from collections import Counter
from collections.abc import Awaitable, Callable
from pathlib import Path
from urllib.parse import quote

import msgspec

from engine.agent.layer_builder import index_in_fork
from engine.processes.instances import folder_of, instance_name, sweep_stale
from engine.specs.containers import LayerSpec
from engine.specs.layer_files import INDEX, open_layers
from ppaas.errors import InvalidParameter, InvalidPlanner, Unavailable

__all__ = ["Builder", "MapCache", "instance_name", "open_layers", "sweep_stale"]

Builder = Callable[[LayerSpec, Path], Awaitable[None]]
"""Writes layers into an empty folder."""

Indexer = Callable[[Path, str], Awaitable[None]]
"""Puts what a planner, by its name, prepares of a map beside its layers."""

SPARE = 4
"""Map versions that are kept though nobody uses them: a robot that comes back finds its map."""


class MapCache:
    """Layers of maps, in folders that appear whole or not at all. It belongs to one event loop.

    Parameters
    ----------
    root : Path
        Folder of its own, in shared memory; made if it is not there.
    build : callable
        Makes layers. It is not asked for those that are here: a map that was used can be used while its store is away.
    index : callable, optional
        Makes indexes; without it, in such a process as well.
    spare : int
        Layers that are kept though nobody uses them.
    """

    def __init__(self, root: Path, *, build: Builder, index: Indexer = index_in_fork, spare: int = SPARE) -> None:
        self._root = root
        self._build = build
        self._index = index
        self._spare = spare
        self._users: Counter[Path] = Counter()
        self._unused: dict[Path, None] = {}  # in order of their release
        self._building: dict[Path, asyncio.Task[None]] = {}
        self._indexing: dict[Path, asyncio.Task[None]] = {}
        self._refused: dict[Path, InvalidPlanner] = {}
        root.mkdir(mode=0o700, parents=True, exist_ok=True)

    @classmethod
    def of_instance(cls, instance: str, build: Builder) -> "MapCache":
        """Return the cache of a running cloud on this machine, after those of dead ones were removed."""
        sweep_stale()
        return cls(folder_of(instance), build=build)

    async def ensure(self, spec: LayerSpec) -> Path:
        """Return the folder with the layers of a map, made now if need be; ``release`` it when it is not used any more.

        However many ask at once, the layers are made once.

        Parameters
        ----------
        spec : LayerSpec
            Of what they are made.

        Raises
        ------
        InvalidMap
            The files are no map, or those of a mask.
        NotFound
            The map is gone, or a mask.
        Unavailable
            Its store is away, or there is no room in shared memory, even without the layers that nobody uses.
        """
        folder = self._root / _name(spec)
        self._users[folder] += 1
        self._unused.pop(folder, None)
        try:
            if not folder.exists():
                await asyncio.shield(self._making(folder, spec))
        except BaseException:
            self.release(folder)
            raise
        return folder

    async def prepare(self, folder: Path, planner: str) -> None:
        """Put what a planner prepares of a map beside its layers, which the caller uses; nothing to do if it is there.

        However many ask at once, it is made once; so is the attempt, where the planner cannot prepare the map.

        Raises
        ------
        NotFound
            No planner of that name makes an index that can be shared.
        InvalidPlanner
            The planner cannot prepare this map.
        Unavailable
            There is no room in shared memory, even without the layers that nobody uses.
        """
        path = folder / f"{quote(planner, safe='')}{INDEX}"
        if path in self._refused:
            raise self._refused[path]
        if path.exists():
            return
        if path not in self._indexing:
            self._users[folder] += 1  # whoever asks may give up meanwhile
            task = self._indexing[path] = asyncio.create_task(self._make_index(folder, planner))
            task.add_done_callback(lambda _: self._indexed(folder, path))
        await asyncio.shield(self._indexing[path])

    async def _make_index(self, folder: Path, planner: str) -> None:
        try:
            await self._index(folder, planner)
        except Unavailable:
            if not self._unused:
                raise
            self._drop_unused(keep=0)
            await self._index(folder, planner)

    def _indexed(self, folder: Path, path: Path) -> None:
        task = self._indexing.pop(path)
        if not task.cancelled() and isinstance(error := task.exception(), InvalidPlanner):
            self._refused[path] = error
        self.release(folder)

    def release(self, folder: Path) -> None:
        """Use layers no more, once for each ``ensure``; they stay for a while."""
        if self._users[folder] < 1:
            raise ValueError(f"{folder} was released more often than it was taken")
        self._users[folder] -= 1
        if self._users[folder]:
            return
        del self._users[folder]
        if folder not in self._building and folder.exists():
            self._unused[folder] = None
            self._drop_unused(keep=self._spare)

    def remove_all(self) -> None:
        """Remove all layers and the folder itself. Processes that have mapped them keep what they mapped."""
        for task in (*self._building.values(), *self._indexing.values()):
            task.cancel()
        shutil.rmtree(self._root, ignore_errors=True)
        self._unused.clear()

    def _drop_unused(self, keep: int) -> None:
        while len(self._unused) > keep:
            oldest = next(iter(self._unused))
            del self._unused[oldest]
            self._refused = {path: error for path, error in self._refused.items() if path.parent != oldest}
            shutil.rmtree(oldest, ignore_errors=True)

    def _making(self, folder: Path, spec: LayerSpec) -> asyncio.Task[None]:
        if folder not in self._building:
            task = asyncio.create_task(self._make(folder, spec))
            self._building[folder] = task
            task.add_done_callback(lambda _: self._made(folder))
        return self._building[folder]

    def _made(self, folder: Path) -> None:
        del self._building[folder]
        if folder not in self._users and folder.exists():  # all who asked have given up
            self._unused[folder] = None
            self._drop_unused(keep=self._spare)

    async def _make(self, folder: Path, spec: LayerSpec) -> None:
        try:
            await self._make_aside(folder, spec)
        except Unavailable:
            if not self._unused:
                raise
            self._drop_unused(keep=0)
            await self._make_aside(folder, spec)

    async def _make_aside(self, folder: Path, spec: LayerSpec) -> None:
        aside = self._root / f".making-{os.getpid()}-{secrets.token_hex(4)}"
        aside.mkdir()
        try:
            await self._build(spec, aside)
            aside.rename(folder)
        finally:
            shutil.rmtree(aside, ignore_errors=True)


def _name(spec: LayerSpec) -> str:
    if not 0.0 <= spec.robot_radius < 100.0:
        raise InvalidParameter(f"the radius of a robot is from 0 to 100 m, not {spec.robot_radius}")
    name = f"map-{quote(spec.map.id, safe='')}@{quote(spec.map.version, safe='')}@{spec.robot_radius:.4f}m"
    if not spec.masks and spec.heights is None:
        return name
    more = msgspec.json.encode((spec.masks, spec.heights), order="deterministic")  # hashed: a file's name has an end
    return f"{name}@{hashlib.sha256(more).hexdigest()[:32]}"
