"""What processes leave behind: zombies, shared memory, control groups, temporary files, open files."""

from collections.abc import Iterable
from pathlib import Path

import psutil

from ppaas.clock import Clock, monotonic
from robots.bench.chaos.family import Member, members

SHARED_MEMORY = Path("/dev/shm")
CGROUPS = Path("/sys/fs/cgroup")

ZOMBIE_GRACE = 10.0
"""Seconds in which whoever has to must have taken note of a process that ended."""

KEPT = frozenset(("data", "password", "ready.json", "log", "machines"))
"""What of a cloud's folder is meant to stay."""

COUNTED = frozenset(("web", "agent", "joined machine", "router"))
"""Processes that live on, so that what they open and do not close adds up."""


class Traces:
    """Looks at the processes of a cloud again and again, and at the end at what is left of them.

    Parameters
    ----------
    folder : Path
        For their temporary files.
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, folder: Path, clock: Clock = monotonic) -> None:
        self._folder = folder
        self._clock = clock
        self._before = _names(SHARED_MEMORY)
        self._own_groups = _groups("self")
        self._seen: dict[int, psutil.Process] = {}
        self._shared: set[str] = set()
        self._groups: set[str] = set()
        self._dead_since: dict[psutil.Process, float] = {}
        self._files: dict[str, int] = {}
        self.wrong: list[str] = []

    def look(self) -> list[Member]:
        """Note what there is now; return the processes that run."""
        found = members(self._folder)
        new = _names(SHARED_MEMORY) - self._before - self._shared
        for member in found:
            self._seen[member.process.pid] = member.process
            self._groups |= _groups(str(member.process.pid)) - self._own_groups
            self._shared |= {name for name in new if name in _maps(member.process.pid)}
        self._look_for_zombies()
        return found

    def _look_for_zombies(self) -> None:
        now = self._clock()
        dead = {process for process in self._seen.values() if _is_zombie(process)}
        self._dead_since = {process: self._dead_since.get(process, now) for process in dead}
        for process, since in self._dead_since.items():
            if now - since > ZOMBIE_GRACE:
                self.wrong.append(f"process {process.pid} has been a zombie for {now - since:.0f} s")
                del self._seen[process.pid]

    def count_files(self, found: Iterable[Member], more: int | None = None) -> None:
        """Note how many files each kind of process has open; with ``more``, tell of those that have so many more."""
        for member in found:
            if member.kind not in COUNTED:
                continue
            try:
                count = member.process.num_fds()
            except psutil.Error:  # it ended just now
                continue
            if more is None:
                self._files[member.kind] = max(count, self._files.get(member.kind, 0))
            elif count > self._files.get(member.kind, count) + more:
                self.wrong.append(f"a process ({member.kind}) has {count} files open, from {self._files[member.kind]}")

    def at_end(self) -> None:
        """Tell of what is left after all was ended."""
        for member in self.look():
            self.wrong.append(f"process {member.process.pid} ({member.kind} of {member.home}) is left")
        for name in sorted(_names(SHARED_MEMORY) - self._before):
            if name in self._shared or self._is_of_ours(name):
                self.wrong.append(f"{SHARED_MEMORY / name} is left")
        for group in sorted(self._groups):
            controller, path = group.split(":", 2)[1:]
            if (CGROUPS / controller / path.lstrip("/")).is_dir():
                self.wrong.append(f"control group {group} is left")
        for home in (self._folder, *sorted((self._folder / "machines").glob("*/t"))):
            self.wrong += [f"{left} is left" for left in sorted(home.iterdir()) if left.name not in KEPT]

    def _is_of_ours(self, name: str) -> bool:
        """Tell whether a folder in shared memory is named after one of the processes that were seen."""
        return name.startswith("ppaas-") and any(f"-{pid}-" in name for pid in self._seen)


def _names(folder: Path) -> set[str]:
    return {entry.name for entry in folder.iterdir()}


def _groups(pid: str) -> set[str]:
    try:
        return set(Path(f"/proc/{pid}/cgroup").read_text().splitlines())
    except OSError:
        return set()


def _maps(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/maps").read_text()
    except OSError:
        return ""


def _is_zombie(process: psutil.Process) -> bool:
    """Tell whether a process ended, and the process of ours that started it has not taken note of it."""
    try:
        return bool(process.is_running() and process.status() == psutil.STATUS_ZOMBIE and process.ppid() != 1)
    except psutil.Error:
        return False
