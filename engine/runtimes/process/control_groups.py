"""Control groups of container processes: CPU weight and memory limit, where this user may create groups.

In version 1, groups are created below this process's groups, one for each controller. Version 2 does not allow a group
to have both processes and children with limits. There, groups are created beside this process's group, in a group that
was delegated to its user, as by ``Delegate=yes`` with ``DelegateSubgroup=`` (systemd.resource-control(5)). They have no
common parent of ours: on a busy computer all containers together would weigh as much as a single process.
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
"""CPU weight per core, in units of an ordinary process: a container of a quarter of a core, the size of a clone,
weighs as much as one process."""

PAUSES = (0.02, 0.1, 0.3, None)
"""Pauses before the second, third … attempt to remove a group [s]: a process in it may be about to exit."""

Settings = Mapping[str, Callable[[Launch], int]]
"""Files of a group, each with the function that computes its value for a container."""


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
    """A place where groups can be created, and the limits that they set.

    Parameters
    ----------
    parent : Path
        Parent group.
    settings : mapping
        Files of each group.
    first : mapping of Path to str
        Files, and their content, to write before the first group is created.
    """

    parent: Path
    settings: Settings
    first: Mapping[Path, str] = field(default_factory=dict)


def hierarchies(mounts: str, own: str) -> list[Hierarchy]:
    """Return the places where this process might be able to create groups.

    Parameters
    ----------
    mounts, own : str
        Content of ``/proc/self/mounts`` and ``/proc/self/cgroup``.
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
                # All other processes share one group; containers must not slow it down.
                first = {group.parent / CHILDREN_HAVE: "+cpu +memory", group / WEIGHT: str(MOST_WEIGHT)}
                found.append(Hierarchy(group.parent, V2, first))
    return found


def own_hierarchies() -> list[Hierarchy]:
    """Return the places where this process might be able to create groups."""
    return hierarchies(_read(Path("/proc/self/mounts")), _read(Path("/proc/self/cgroup")))


class ControlGroups:
    """The control groups of the containers of one machine.

    The kernel may take milliseconds for each change of a group, so they are made in a thread.

    Parameters
    ----------
    instance : str
        Name of the cloud process that this machine belongs to.
    places : iterable of Hierarchy
        Places to try. Where groups cannot be created, containers have no limits.
    """

    def __init__(self, instance: str, places: Iterable[Hierarchy]) -> None:
        self._name = f"{PREFIX}{instance}"
        self._places = [place for place in places if _is_ours(place, self._name)]
        self._worker = ThreadPoolExecutor(1, "control-groups")

    @property
    def controlled(self) -> list[str]:
        """Names of the files that limit containers to their size."""
        return [file for place in self._places for file in place.settings]

    def put(self, pid: int, launch: Launch) -> "Future[None]":
        """Create groups of the size of a launch, and move a process into them."""
        return self._worker.submit(self._put, pid, launch)

    def resize(self, launch: Launch) -> "Future[None]":
        """Limit a container to another size; memory in use is not taken away."""
        return self._worker.submit(self._resize, launch)

    def remove(self, container: str) -> "Future[None]":
        """Remove the groups of a container that has ended."""
        return self._worker.submit(self._remove, container)

    async def close(self) -> None:
        """Remove all groups."""
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
                return  # the process has exited already
            except OSError as error:
                logger.warning("container %s is not limited to its size by %s: %s", launch.spec.id, group, error)

    def _resize(self, launch: Launch) -> None:
        for group, settings in self._groups(launch.spec.id):
            try:
                _set(group, settings, launch)
            except OSError as error:
                logger.warning("container %s keeps its old size in %s: %s", launch.spec.id, group, error)

    def _remove(self, container: str) -> None:
        for group, _ in self._groups(container):
            _remove(group)

    def _close(self) -> None:
        self._worker.shutdown()
        for place in self._places:
            _remove_all(place.parent, self._name)
        self._places = []


def _is_ours(place: Hierarchy, name: str) -> bool:
    """Return whether this process can create groups there; remove the groups of killed agents first."""
    probe = place.parent / f"{name}.probe"
    try:
        _sweep(place.parent)
        _remove_all(place.parent, name)
        for file, text in place.first.items():
            file.write_text(text)
        probe.mkdir()
        probe.rmdir()
    except OSError as error:
        logger.info("control groups cannot be created in %s, so they do not limit containers: %s", place.parent, error)
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
            if pause is None:  # a process that the container started still runs; the next machine tries again
                logger.warning("control group %s cannot be removed: %s", group, error)
                return
            time.sleep(pause)
        else:
            return
