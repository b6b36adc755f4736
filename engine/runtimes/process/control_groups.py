"""Control groups of containers that are processes: CPUs by weight and memory by limit, where this user may make some.

In version 1 they are made below those of this process, one for each controller. Version 2 lets no group have processes
and also groups with limits: there they are made beside that of this process, in one that was delegated to its user, as
by ``Delegate=yes`` with ``DelegateSubgroup=`` (systemd.resource-control(5)). No group of ours is around them: on a busy
computer all containers together would weigh as much as a single process.
"""

import asyncio
import logging
import math
import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from engine.processes.instances import is_dead
from engine.runtimes.memory_limits import memory_of
from engine.specs.containers import Launch

logger = logging.getLogger(__name__)

PREFIX = "ppaas-"

PROCESSES, CHILDREN_HAVE, WEIGHT = "cgroup.procs", "cgroup.subtree_control", "cpu.weight"

TASKS_PER_CORE = 4
"""A container of a quarter of a core, as a clone has, weighs as much as any process; others in proportion."""

PAUSES = (0.02, 0.1, 0.3, None)
"""Seconds before the second, third … try to remove a group, in which something may be about to end."""

Settings = Mapping[str, Callable[[Launch], int]]
"""Files of a group, and what stands in each for a container."""


def _weight(one_task: int, least: int, most: int) -> Callable[[Launch], int]:
    return lambda launch: min(most, max(least, math.ceil(launch.spec.cores * TASKS_PER_CORE * one_task)))


V1: Mapping[str, Settings] = {
    "cpu": {"cpu.shares": _weight(1024, 2, 262_144)},
    "memory": {"memory.limit_in_bytes": memory_of},
}

MOST_WEIGHT = 10_000

V2: Settings = {WEIGHT: _weight(100, 1, MOST_WEIGHT), "memory.max": memory_of}


@dataclass(frozen=True)
class Hierarchy:
    """Where groups can be made, and what they are held to.

    Parameters
    ----------
    parent : Path
        Group in which they are.
    settings : mapping
        Their files.
    first : mapping of Path to str
        What has to be written before the first is made.
    """

    parent: Path
    settings: Settings
    first: Mapping[Path, str] = field(default_factory=dict)


def hierarchies(mounts: str, own: str) -> list[Hierarchy]:
    """Return where this process might make groups.

    Parameters
    ----------
    mounts, own : str
        What ``/proc/self/mounts`` and ``/proc/self/cgroup`` say.
    """
    groups = {names: path for _, names, path in (line.split(":", 2) for line in own.splitlines())}
    found = []
    for _, place, kind, options, *_ in (line.split() for line in mounts.splitlines()):
        if kind == "cgroup":
            named = [
                (names, path) for names, path in groups.items() if set(names.split(",")) <= set(options.split(","))
            ]
            for names, path in named:
                found += [Hierarchy(_below(place, path), V1[name]) for name in names.split(",") if name in V1]
        elif kind == "cgroup2" and groups.get("", "/") != "/":
            group = _below(place, groups[""])
            if {"cpu", "memory"} <= set(_read(group.parent / "cgroup.controllers").split()):
                # All that is no container is in one group, which must not wait for any of them.
                first = {group.parent / CHILDREN_HAVE: "+cpu +memory", group / WEIGHT: str(MOST_WEIGHT)}
                found.append(Hierarchy(group.parent, V2, first))
    return found


def own_hierarchies() -> list[Hierarchy]:
    """Return where this very process might make groups."""
    return hierarchies(_read(Path("/proc/self/mounts")), _read(Path("/proc/self/cgroup")))


class ControlGroups:
    """The groups of the containers of one machine. The kernel may take milliseconds for one, so a thread asks it.

    Parameters
    ----------
    instance : str
        Name of the cloud process whose machine it is.
    places : iterable of Hierarchy
        Where groups might be made; where they cannot, containers are not held to anything.
    """

    def __init__(self, instance: str, places: Iterable[Hierarchy]) -> None:
        self._name = f"{PREFIX}{instance}"
        self._places = [place for place in places if _is_ours(place, self._name)]
        self._worker = ThreadPoolExecutor(1, "control-groups")

    @property
    def controlled(self) -> list[str]:
        """Names of the files that hold containers to their size."""
        return [file for place in self._places for file in place.settings]

    def put(self, pid: int, launch: Launch) -> "Future[None]":
        """Put a process into groups of its own, of the size of its launch."""
        return self._worker.submit(self._put, pid, launch)

    def resize(self, launch: Launch) -> "Future[None]":
        """Hold a container to another size; memory that it uses is not taken from it."""
        return self._worker.submit(self._resize, launch)

    def remove(self, container: str) -> "Future[None]":
        """Remove the groups of a container that has ended."""
        return self._worker.submit(self._remove, container)

    async def close(self) -> None:
        """Remove all."""
        await asyncio.to_thread(self._close)

    # -- in the thread -------------------------------------------------------------------------------------------------

    def _groups(self, container: str) -> list[tuple[Path, Settings]]:
        return [(place.parent / f"{self._name}.{container}", place.settings) for place in self._places]

    def _put(self, pid: int, launch: Launch) -> None:
        for group, settings in self._groups(launch.spec.id):
            try:
                group.mkdir()
                _set(group, settings, launch)
                (group / PROCESSES).write_text(str(pid))
            except ProcessLookupError:
                return  # it has ended already
            except OSError as error:
                logger.warning("container %s is not held to its size by %s: %s", launch.spec.id, group, error)

    def _resize(self, launch: Launch) -> None:
        for group, settings in self._groups(launch.spec.id):
            try:
                _set(group, settings, launch)
            except OSError as error:
                logger.warning("container %s keeps the size that it had in %s: %s", launch.spec.id, group, error)

    def _remove(self, container: str) -> None:
        for group, _ in self._groups(container):
            _remove(group)

    def _close(self) -> None:
        self._worker.shutdown()
        for place in self._places:
            _remove_all(place.parent, self._name)
        self._places = []


def _is_ours(place: Hierarchy, name: str) -> bool:
    """Tell whether we can make groups there, where nothing is left of agents before this one that were killed."""
    probe = place.parent / f"{name}.probe"
    try:
        _sweep(place.parent)
        _remove_all(place.parent, name)
        for file, text in place.first.items():
            file.write_text(text)
        probe.mkdir()
        probe.rmdir()
    except OSError as error:
        logger.info("sizes are not held by control groups in %s: %s", place.parent, error)
        return False
    return True


def _set(group: Path, settings: Settings, launch: Launch) -> None:
    for file, value in settings.items():
        (group / file).write_text(str(value(launch)))


def _below(place: str, path: str) -> Path:
    return Path(place, path.lstrip("/"))


def _read(path: Path) -> str:
    try:
        return path.read_text()
    except OSError:
        return ""


def _sweep(parent: Path) -> None:
    """Remove what dead clouds have left."""
    for left in parent.glob(f"{PREFIX}*"):
        if is_dead(left.name.removeprefix(PREFIX).partition(".")[0]):
            _remove(left)


def _remove_all(parent: Path, name: str) -> None:
    for group in parent.glob(f"{name}.*"):
        _remove(group)


def _remove(group: Path) -> None:
    for pause in PAUSES:
        try:
            group.rmdir()
        except FileNotFoundError:
            return
        except OSError as error:
            if pause is None:  # what it has started runs on; the next machine tries again
                logger.warning("control group %s is left: %s", group, error)
                return
            time.sleep(pause)
        else:
            return
