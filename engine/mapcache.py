"""The maps of a machine: the layers of each map version and robot radius, made once and shared by all containers."""

import asyncio
import os
import secrets
import shutil
from collections import Counter
from collections.abc import Awaitable, Callable
from pathlib import Path
from urllib.parse import quote

from engine.instances import folder_of, instance_name, sweep_stale
from engine.layer_building import build_in_fork
from engine.layer_files import open_layers
from ppaas.errors import InvalidParameter, Unavailable
from storage.records import MapRecord

__all__ = ["Builder", "MapCache", "instance_name", "open_layers", "sweep_stale"]

Builder = Callable[[MapRecord, float, Path], Awaitable[None]]
"""Writes the layers of a map for a robot radius [m] into an empty folder."""

SPARE = 4
"""Map versions that are kept though nobody uses them: a robot that comes back finds its map."""


class MapCache:
    """Layers of maps, in folders that appear whole or not at all. It belongs to one event loop.

    Parameters
    ----------
    root : Path
        Folder of its own, in shared memory; made if it is not there.
    build : callable, optional
        Makes layers; without it, in a process forked from the warm fork server.
    spare : int
        Layers that are kept though nobody uses them.
    """

    def __init__(self, root: Path, *, build: Builder = build_in_fork, spare: int = SPARE) -> None:
        self._root = root
        self._build = build
        self._spare = spare
        self._users: Counter[Path] = Counter()
        self._unused: dict[Path, None] = {}  # in order of their release
        self._building: dict[Path, asyncio.Task[None]] = {}
        root.mkdir(mode=0o700, parents=True, exist_ok=True)

    @classmethod
    def of_instance(cls, instance: str) -> "MapCache":
        """Return the cache of a running cloud on this machine, after those of dead ones were removed."""
        sweep_stale()
        return cls(folder_of(instance))

    async def ensure(self, record: MapRecord, robot_radius: float) -> Path:
        """Return the folder with the layers of a map, made now if need be; ``release`` it when it is not used any more.

        However many ask at once, the layers are made once.

        Parameters
        ----------
        record : MapRecord
            With its files.
        robot_radius : float
            [m].

        Raises
        ------
        InvalidMap
            The files are no map.
        Unavailable
            There is no room in shared memory, even without the layers that nobody uses.
        """
        folder = self._root / _name(record, robot_radius)
        self._users[folder] += 1
        self._unused.pop(folder, None)
        try:
            if not folder.exists():
                await asyncio.shield(self._making(folder, record, robot_radius))
        except BaseException:
            self.release(folder)
            raise
        return folder

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
        for task in self._building.values():
            task.cancel()
        shutil.rmtree(self._root, ignore_errors=True)
        self._unused.clear()

    def _drop_unused(self, keep: int) -> None:
        while len(self._unused) > keep:
            oldest = next(iter(self._unused))
            del self._unused[oldest]
            shutil.rmtree(oldest, ignore_errors=True)

    def _making(self, folder: Path, record: MapRecord, robot_radius: float) -> asyncio.Task[None]:
        if folder not in self._building:
            task = asyncio.create_task(self._make(folder, record, robot_radius))
            self._building[folder] = task
            task.add_done_callback(lambda _: self._made(folder))
        return self._building[folder]

    def _made(self, folder: Path) -> None:
        del self._building[folder]
        if folder not in self._users and folder.exists():  # all who asked have given up
            self._unused[folder] = None
            self._drop_unused(keep=self._spare)

    async def _make(self, folder: Path, record: MapRecord, robot_radius: float) -> None:
        try:
            await self._make_aside(folder, record, robot_radius)
        except Unavailable:
            if not self._unused:
                raise
            self._drop_unused(keep=0)
            await self._make_aside(folder, record, robot_radius)

    async def _make_aside(self, folder: Path, record: MapRecord, robot_radius: float) -> None:
        aside = self._root / f".making-{os.getpid()}-{secrets.token_hex(4)}"
        aside.mkdir()
        try:
            await self._build(record, robot_radius, aside)
            aside.rename(folder)
        finally:
            shutil.rmtree(aside, ignore_errors=True)


def _name(record: MapRecord, robot_radius: float) -> str:
    if not 0.0 <= robot_radius < 100.0:
        raise InvalidParameter(f"the radius of a robot is from 0 to 100 m, not {robot_radius}")
    return f"map-{quote(record.id, safe='')}@{quote(record.version, safe='')}@{robot_radius:.4f}m"
