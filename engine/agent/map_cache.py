"""Map cache of a machine: the layers of each map version and robot radius, made once and shared by all containers."""

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
from engine.specs.layer_files import INDEX, changed_cells, open_layers
from ppaas.bounded import BoundedDict
from ppaas.errors import InvalidParameter, InvalidPlanner, Unavailable
from ppaas.maps.cell_rectangle import Rectangle

__all__ = ["Builder", "MapCache", "instance_name", "open_layers", "sweep_stale"]

Builder = Callable[[LayerSpec, Path], Awaitable[None]]
"""Writes layers into an empty folder."""

Indexer = Callable[[Path, str], Awaitable[None]]
"""Makes the index of the planner with the given name, in a folder with layers."""

SPARE = 4
"""Number of unused layer folders that are kept, for robots that return."""

COMPARISONS = 16
"""Number of comparisons of maps that are remembered, for containers that follow later."""


class MapCache:
    """Cache of layers, each in a folder that is created atomically. Not thread-safe: use it in one event loop.

    Parameters
    ----------
    root : Path
        Folder of the cache, in shared memory; created if it does not exist.
    build : callable
        Makes layers. It is not called for cached ones, so a cached map is usable while its store is unavailable.
    index : callable, optional
        Makes indexes; by default in a forked process, as the layers are.
    spare : int
        Number of unused layer folders that are kept.
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
        self._comparing: BoundedDict[tuple[Path, Path], asyncio.Task[list[Rectangle] | None]] = BoundedDict(COMPARISONS)
        root.mkdir(mode=0o700, parents=True, exist_ok=True)

    @classmethod
    def of_instance(cls, instance: str, build: Builder) -> "MapCache":
        """Return the cache of this cloud process, and remove the caches of cloud processes that have died."""
        sweep_stale()
        return cls(folder_of(instance), build=build)

    async def ensure(self, spec: LayerSpec) -> Path:
        """Return the folder with the layers of a map, making them if needed; ``release`` it after use.

        Concurrent calls for the same layers make them once.

        Parameters
        ----------
        spec : LayerSpec
            Map version, robot radius, masks, heights and costs of the layers.

        Raises
        ------
        InvalidMap
            The files of the map or of a mask are not valid.
        InvalidParameter
            The robot radius is outside [0, 100) m, or a mask does not exist or is not a grid.
        NotFound
            The map does not exist.
        Unavailable
            The store is unavailable, or shared memory is full, even after unused layers were removed.
        """
        folder = self._root / _name(spec)
        # Before they are made: unused layers may be removed at any time.
        self._users[folder] += 1
        self._unused.pop(folder, None)
        try:
            if not folder.exists():
                # Others may wait for the same layers, so a caller that is cancelled does not end it.
                await asyncio.shield(self._making(folder, spec))
        except BaseException:
            self.release(folder)
            raise
        return folder

    async def prepare(self, folder: Path, planner: str) -> None:
        """Make a planner's index of a map, in a folder of layers that the caller uses, unless it exists.

        Concurrent calls for the same index make it once. A planner that cannot prepare the map is not tried again.

        Raises
        ------
        NotFound
            No planner of that name makes an index that can be shared.
        InvalidPlanner
            The planner cannot prepare this map.
        Unavailable
            Shared memory is full, even after unused layers were removed.
        """
        path = folder / f"{quote(planner, safe='')}{INDEX}"
        if path in self._refused:
            raise self._refused[path]
        if path.exists():
            return
        if path not in self._indexing:
            self._users[folder] += 1  # keeps the folder in use even if all callers are cancelled
            task = self._indexing[path] = asyncio.create_task(self._make_index(folder, planner))
            task.add_done_callback(lambda _: self._indexed(folder, path))
        await asyncio.shield(self._indexing[path])

    async def _make_index(self, folder: Path, planner: str) -> None:
        try:
            await self._index(folder, planner)
        except Unavailable:
            if not self._unused:
                raise
            # Shared memory may be full of layers that nobody uses.
            self._drop_unused(keep=0)
            await self._index(folder, planner)

    def _indexed(self, folder: Path, path: Path) -> None:
        task = self._indexing.pop(path)
        if not task.cancelled() and isinstance(error := task.exception(), InvalidPlanner):
            self._refused[path] = error
        self.release(folder)

    async def changes(self, before: Path, after: Path) -> list[Rectangle] | None:
        """Return rectangles that cover the cells in which the maps of two folders differ, which the caller uses.

        None if their sizes or origins differ. The maps are compared once for all containers; a comparison that failed
        is repeated at the next call.

        Raises
        ------
        Unavailable
            A folder has no complete layers.
        """
        task = self._comparing.get((before, after))
        if task is None or _has_failed(task):
            task = asyncio.create_task(asyncio.to_thread(changed_cells, before, after))
            self._comparing[before, after] = task
        return await asyncio.shield(task)

    def release(self, folder: Path) -> None:
        """End one use of layers, once for each ``ensure``; unused layers are kept for a while."""
        if self._users[folder] < 1:
            raise ValueError(f"{folder} was released more often than ensure() returned it")
        self._users[folder] -= 1
        if self._users[folder]:
            return
        del self._users[folder]
        if folder not in self._building and folder.exists():
            self._unused[folder] = None
            self._drop_unused(keep=self._spare)

    def remove_all(self) -> None:
        """Remove all layers and the folder itself. Processes that have mapped layers keep their mappings."""
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
        if folder not in self._users and folder.exists():  # all callers were cancelled
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


def _has_failed(task: asyncio.Task[list[Rectangle] | None]) -> bool:
    return task.done() and (task.cancelled() or task.exception() is not None)


def _name(spec: LayerSpec) -> str:
    if not 0.0 <= spec.robot_radius < 100.0:
        raise InvalidParameter(f"robot radius must be at least 0 m and less than 100 m, not {spec.robot_radius}")
    name = f"map-{quote(spec.map.id, safe='')}@{quote(spec.map.version, safe='')}@{spec.robot_radius:.4f}m"
    if spec.posegraph:
        return f"{name}@posegraph"
    if not spec.masks and spec.heights is None and not spec.costs.changed:
        return name
    # hashed, since the length of a file name is limited
    more = msgspec.json.encode((spec.masks, spec.heights, spec.costs), order="deterministic")
    return f"{name}@{hashlib.sha256(more).hexdigest()[:32]}"
