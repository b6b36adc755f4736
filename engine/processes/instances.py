"""Unique names of processes on one machine, and what they leave in shared memory: folders and semaphores."""

import contextlib
import os
import re
import shutil
from multiprocessing import process
from pathlib import Path

from storage.own_files import is_own_file, is_own_folder

SHARED_MEMORY = Path("/dev/shm")

_NAME = re.compile(r"(\d+)-(\d+)-(\d+)")
_SEMAPHORE = re.compile(r"sem\.ppaas-(\d+-\d+-\d+)-.+")


def instance_name() -> str:
    """Return a name of this process that is never reused on this machine: PID namespace, process id and start time."""
    name = name_of(os.getpid())
    if name is None:
        raise RuntimeError("/proc has no entry of this process")
    return name


def name_of(pid: int) -> str | None:
    """Return the name of a process of this PID namespace, as ``instance_name`` does; None if it has exited."""
    started = _start_of(pid)
    return f"{_namespace()}-{pid}-{started}" if started is not None else None


def pid_of(instance: str) -> int:
    """Return the process id of an instance name."""
    return int(instance.split("-")[1])


def folder_of(instance: str, base: Path = SHARED_MEMORY) -> Path:
    """Return the folder of an instance in shared memory."""
    return base / f"ppaas-{instance}"


def name_semaphores() -> None:
    """Name the semaphores that multiprocessing makes in this process, and in its children, after this process.

    Its resource tracker removes the semaphores of a killed process, unless it is killed as well; `sweep_stale` does so
    then.
    """
    process.current_process()._config["semprefix"] = f"/ppaas-{instance_name()}"  # type: ignore[attr-defined]


def sweep_stale(base: Path = SHARED_MEMORY) -> list[Path]:
    """Remove the folders and semaphores of dead instances of this user, and return their paths.

    Instances of another PID namespace are left alone, since their processes may still run.
    """
    named = [folder for folder in sorted(base.glob("ppaas-*")) if is_dead(folder.name.removeprefix("ppaas-"))]
    folders = [folder for folder in named if is_own_folder(folder)]
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)  # another process may remove it at the same time
    semaphores = [file for file in sorted(base.glob("sem.ppaas-*")) if _is_stale_semaphore(file)]
    for file in semaphores:
        with contextlib.suppress(FileNotFoundError):  # as above
            file.unlink()
    return folders + semaphores


def _is_stale_semaphore(file: Path) -> bool:
    found = _SEMAPHORE.fullmatch(file.name)
    return found is not None and is_dead(found[1]) and is_own_file(file)


def is_dead(instance: str) -> bool:
    """Return whether an instance is known to be dead: it is of this PID namespace, and its process has exited."""
    found = _NAME.fullmatch(instance)
    if found is None:
        return False
    namespace, pid, started = map(int, found.groups())
    return namespace == _namespace() and _start_of(pid) != started


def _namespace() -> int:
    return Path("/proc/self/ns/pid").stat().st_ino


def _start_of(pid: int) -> int | None:
    """Return the start time of a process [clock ticks since boot], or None if it has exited."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return None
    state, *fields = stat.rpartition(")")[2].split()
    return int(fields[18]) if state not in "ZX" else None
