"""Processes of a cloud and its machines, found by their temporary folder, and files that they left behind."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import msgspec
import psutil

from endpoints.cloud_processes import serving
from engine.agent import main as agent
from engine.fabric import router
from engine.remote import agent as joined_agent
from engine.runtimes.compilation import rest_compiler
from ppaas.clock import Clock, monotonic
from ppaas.decoding import from_json
from robots import cli
from robots.demo.cloud_process import CloudReady

STANDBY = "standby"
"""Kind of a cloud process that was started as a standby and does not lead yet."""

FORKED = "forkserver"
"""Word in the command line of a fork server and its children."""

MACHINES = "machines"
"""Subfolder of the cloud's folder that has a folder for each joined machine, by its name."""

OWN = "local"
"""Name of the cloud's local machine."""

_BY_COMMAND = {
    f"{cli.__name__} up": "master",
    serving.__name__: "endpoint",
    joined_agent.__name__: "joined machine",
    agent.__name__: "agent",
    router.__name__: "router",
    rest_compiler.__name__: "compiler",
    "resource_tracker": "resource tracker",
    FORKED: FORKED,
}


@dataclass(frozen=True, slots=True)
class CloudProcessInfo:
    """A process of a cloud.

    Parameters
    ----------
    process : psutil.Process
        The process.
    kind : str
        ``master``, ``standby``, ``endpoint``, ``agent``, ``joined machine``, ``router``, ``fork server``, ``forked``
        (a container, or a process that builds the layers of a map), ``compiler``, ``resource tracker`` or ``other``.
    home : str
        Name of its machine.
    """

    process: psutil.Process
    kind: str
    home: str


def cloud_processes(folder: Path) -> list[CloudProcessInfo]:
    """Return all processes whose folder for temporary files is ``folder`` or below it; zombies are not found."""
    found = []
    for process in psutil.process_iter():
        try:
            home = Path(process.environ().get("TMPDIR", ""))
            if home.is_relative_to(folder):
                kind = _kind(process)
                kind = STANDBY if kind == "master" and not _leads(process, home) else kind
                found.append(CloudProcessInfo(process, kind, machine_of(home.relative_to(folder))))
        except psutil.Error:  # it has just exited, or belongs to another user
            continue
    return found


def machine_of(home: Path) -> str:
    """Return the machine of a folder for temporary files, given relative to the cloud's folder."""
    return home.parts[1] if home.parts[:1] == (MACHINES,) else OWN


def _leads(process: psutil.Process, home: Path) -> bool:
    """Return whether a cloud process leads: a standby has no ready file until then."""
    if "--standby" not in process.cmdline():
        return True
    try:
        return from_json((home / "ready.json").read_bytes(), CloudReady).pid == process.pid
    except (FileNotFoundError, msgspec.DecodeError):
        return False


def _kind(process: psutil.Process) -> str:
    kind = _kind_of(" ".join(process.cmdline()))
    if kind != FORKED:
        return kind
    parent = process.parent()
    forked = parent is not None and _kind_of(" ".join(parent.cmdline())) == FORKED
    return "forked" if forked else "fork server"


def _kind_of(command: str) -> str:
    return next((kind for words, kind in _BY_COMMAND.items() if words in command), "other")


# -- leftovers of processes --------------------------------------------------------------------------------------------

SHARED_MEMORY = Path("/dev/shm")
CGROUPS = Path("/sys/fs/cgroup")

ZOMBIE_GRACE = 10.0
"""Time within which the parent of an exited process must have reaped it [s]."""

KEPT = frozenset(("data", "password", "ready.json", "log", MACHINES))
"""Entries of a cloud's folder that are meant to stay."""

COUNTED = frozenset(("master", "endpoint", "agent", "joined machine", "router"))
"""Kinds of long-lived processes, whose open files are counted to find leaks."""


class Leftovers:
    """Checks the processes of a cloud repeatedly, and their leftovers at the end.

    Parameters
    ----------
    folder : Path
        Folder of the cloud for temporary files.
    tell : callable
        Called with a description of each error.
    clock : callable
        Monotonic clock [s].
    """

    def __init__(self, folder: Path, tell: Callable[[str], None], clock: Clock = monotonic) -> None:
        self._folder = folder
        self._tell = tell
        self._clock = clock
        self._before = _names(SHARED_MEMORY)
        self._own_groups = _groups("self")
        self._seen: dict[psutil.Process, str] = {}
        self._shared: set[str] = set()
        self._groups: set[str] = set()
        self._dead_since: dict[psutil.Process, float] = {}
        self._files: dict[str, int] = {}

    def look(self) -> list[CloudProcessInfo]:
        """Record the present state; return the running processes. Takes tenths of a second on a busy computer."""
        found = cloud_processes(self._folder)
        new = _names(SHARED_MEMORY) - self._before - self._shared
        for member in found:
            self._seen[member.process] = member.kind
            self._groups |= _groups(str(member.process.pid)) - self._own_groups
            self._shared |= {name for name in new if name in _maps(member.process.pid)}
        self._look_for_zombies()
        return found

    def _look_for_zombies(self) -> None:
        now = self._clock()
        dead = {process for process in self._seen if _is_zombie(process)}
        self._dead_since = {process: self._dead_since.get(process, now) for process in dead}
        for process, since in self._dead_since.items():
            if now - since > ZOMBIE_GRACE:
                kind = self._seen.pop(process)
                self._tell(f"process {process.pid} ({kind}) has been a zombie for {now - since:.0f} s")

    def count_files(self, more: int | None = None) -> None:
        """Record the number of open files of each kind of process.

        With ``more``, report instead the processes with more than ``more`` files above the recorded number.
        """
        for member in cloud_processes(self._folder):
            if member.kind not in COUNTED:
                continue
            try:
                count = member.process.num_fds()
            except psutil.Error:  # it has just exited
                continue
            if more is None:
                self._files[member.kind] = max(count, self._files.get(member.kind, 0))
            elif count > self._files.get(member.kind, count) + more:
                self._tell(f"a process ({member.kind}) has {count} files open, from {self._files[member.kind]}")

    def at_end(self) -> None:
        """Report everything that is left after all processes have been ended."""
        for member in self.look():
            self._tell(f"process {member.process.pid} ({member.kind} of {member.home}) is left")
        for name in sorted(_names(SHARED_MEMORY) - self._before):
            if name in self._shared or self._is_of_ours(name):
                self._tell(f"{SHARED_MEMORY / name} is left")
        for group in sorted(self._groups):
            controller, path = group.split(":", 2)[1:]
            if (CGROUPS / controller / path.lstrip("/")).is_dir():
                self._tell(f"control group {group} is left")
        for home in (self._folder, *sorted((self._folder / MACHINES).glob("*/t"))):
            for left in sorted(home.iterdir()):
                if left.name not in KEPT:
                    self._tell(f"{left} is left")

    def _is_of_ours(self, name: str) -> bool:
        """Return whether a folder or semaphore in shared memory is named after a process of the cloud."""
        return name.startswith(("ppaas-", "sem.ppaas-")) and any(f"-{process.pid}-" in name for process in self._seen)


def _names(folder: Path) -> set[str]:
    return {entry.name for entry in folder.iterdir()}


def _groups(pid: str) -> set[str]:
    """Return the control groups of a process without the root group, to which it belongs once it has exited."""
    try:
        lines = Path(f"/proc/{pid}/cgroup").read_text().splitlines()
        return {line for line in lines if not line.endswith(":/")}
    except OSError:
        return set()


def _maps(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/maps").read_text()
    except OSError:
        return ""


def _is_zombie(process: psutil.Process) -> bool:
    """Return whether a process is a zombie whose parent runs, is not stopped, and has not reaped it."""
    try:
        if not process.is_running() or process.status() != psutil.STATUS_ZOMBIE or process.ppid() == 1:
            return False
        parent = process.parent()
        return parent is not None and parent.status() != psutil.STATUS_STOPPED
    except psutil.Error:
        return False
