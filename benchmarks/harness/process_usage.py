"""CPU time and memory of processes, read from ``/proc``."""

import asyncio
import os
import re
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import psutil

from endpoints.cloud_processes import serving
from ppaas.clock import monotonic


@dataclass(frozen=True, slots=True)
class ProcessMemory:
    """Memory of one process [MB]; pages that n processes share count 1/n.

    Parameters
    ----------
    pss : float
        Proportional set size without the shared map.
    private : float
        Pages that no other process shares.
    shared_map : float
        Its share of the map's layers.
    """

    pss: float
    private: float
    shared_map: float


def memory_of(pid: int) -> ProcessMemory:
    """Return the memory of a process, from ``/proc/PID/smaps``.

    Raises
    ------
    OSError
        The process has exited or belongs to another user.
    """
    totals: defaultdict[tuple[str, bool], int] = defaultdict(int)
    mapped = False
    for line in Path(f"/proc/{pid}/smaps").read_text().splitlines():
        field, _, rest = line.partition(" ")
        if not field.endswith(":"):
            mapped = "/dev/shm/ppaas-" in line
        elif rest.endswith(" kB"):
            totals[field, mapped] += int(rest[:-3])
    private = totals["Private_Clean:", False] + totals["Private_Dirty:", False]
    return ProcessMemory(totals["Pss:", False] / 1e3, private / 1e3, totals["Pss:", True] / 1e3)


def cpu_seconds(web: int, containers: set[int]) -> dict[str, float]:
    """Return the CPU time that each kind of process has used so far [s].

    Parameters
    ----------
    web : int
        Process id of the cloud's master, whose time counts as ``web`` with that of its endpoints.
    containers : set of int
        Process ids of the containers; all other descendants of the master count as ``machine``.
    """
    used = {"simulator": sum(os.times()[:2]), "web": _cpu(web), "containers": 0.0, "machine": 0.0}
    for process in psutil.Process(web).children(recursive=True):
        kind = "containers" if process.pid in containers else "web" if is_endpoint(process) else "machine"
        used[kind] += _cpu(process.pid)
    return used


def is_endpoint(process: psutil.Process) -> bool:
    """Return whether a process is an endpoint of a cloud."""
    try:
        return serving.__name__ in process.cmdline()
    except psutil.Error:  # it has just exited
        return False


def endpoint_of(cloud: int) -> psutil.Process:
    """Return the endpoint of a cloud that has one, given the process id of its master."""
    [found] = filter(is_endpoint, psutil.Process(cloud).children())
    return found


def cpu_of(process: psutil.Process) -> float:
    """Return the CPU time that a process has used so far, without its children [s].

    Raises
    ------
    psutil.NoSuchProcess
        The process has exited.
    """
    times = process.cpu_times()
    return float(times.user + times.system)


async def share_of_core(process: psutil.Process, seconds: float) -> float:
    """Return the share of a core that a process takes in a time from now on [%]; raises as `cpu_of`."""
    used, began = cpu_of(process), monotonic()
    await asyncio.sleep(seconds)
    return 100.0 * (cpu_of(process) - used) / (monotonic() - began)


def _cpu(pid: int) -> float:
    try:
        return cpu_of(psutil.Process(pid))
    except psutil.NoSuchProcess:
        return 0.0


_PROC = Path("/proc/self")


def resident() -> float:
    """Return the resident memory [MiB]."""
    return _status("VmRSS")


def peak() -> float:
    """Return the largest resident memory since the last `forget_peak` [MiB]."""
    return _status("VmHWM")


def of_files() -> float:
    """Return the part of the resident memory that shows files, such as the code of libraries [MiB]."""
    return _status("RssFile")


def forget_peak() -> None:
    """Let the peak begin at the present memory."""
    (_PROC / "clear_refs").write_text("5")


def _status(name: str) -> float:
    found = re.search(rf"^{name}:\s+(\d+) kB", (_PROC / "status").read_text(), re.MULTILINE)
    assert found is not None
    return int(found[1]) / 1024.0
