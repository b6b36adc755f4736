"""What tells one running cloud from another, and from one that is dead, on the same machine."""

import os
import re
import shutil
from pathlib import Path

SHARED_MEMORY = Path("/dev/shm")

_NAME = re.compile(r"(\d+)-(\d+)-(\d+)")


def instance_name() -> str:
    """Return the name of this process among all that live or lived: PID namespace, process id and start."""
    name = name_of(os.getpid())
    if name is None:
        raise RuntimeError("/proc tells nothing of this process")
    return name


def name_of(pid: int) -> str | None:
    """Return the name of a process of this PID namespace, as ``instance_name`` does; None where it runs no more."""
    started = _start_of(pid)
    return f"{_namespace()}-{pid}-{started}" if started is not None else None


def pid_of(instance: str) -> int:
    """Return the process id in a name."""
    return int(instance.split("-")[1])


def folder_of(instance: str, base: Path = SHARED_MEMORY) -> Path:
    """Return the folder that an instance has in shared memory."""
    return base / f"ppaas-{instance}"


def sweep_stale(base: Path = SHARED_MEMORY) -> list[Path]:
    """Remove the folders of instances that are dead, and return them.

    Those of another PID namespace, which may live, are left alone.
    """
    stale = [folder for folder in sorted(base.glob("ppaas-*")) if is_dead(folder.name.removeprefix("ppaas-"))]
    for folder in stale:
        shutil.rmtree(folder, ignore_errors=True)  # another may sweep at the same time
    return stale


def is_dead(instance: str) -> bool:
    """Tell whether an instance is known to live no more: it was of this PID namespace, and its process is gone."""
    found = _NAME.fullmatch(instance)
    if found is None:
        return False
    namespace, pid, started = map(int, found.groups())
    return namespace == _namespace() and _start_of(pid) != started


def _namespace() -> int:
    return Path("/proc/self/ns/pid").stat().st_ino


def _start_of(pid: int) -> int | None:
    """Return when a process started, in ticks since the machine did; None where it runs no more."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return None
    state, *fields = stat.rpartition(")")[2].split()
    return int(fields[18]) if state not in "ZX" else None
