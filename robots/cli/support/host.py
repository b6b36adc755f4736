"""Facts on this computer for a bundle for support: versions, processors, memory, disk, and sizes of files."""

import os
import platform
import shutil
import sys
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

from ppaas import __version__

MEMORY = Path("/proc/meminfo")
"""Memory of the computer (proc(5))."""

PRESSURE = Path("/proc/pressure")
"""Waits for processors, memory and disks (Linux, PSI)."""


def versions() -> dict[str, Any]:
    """Return the versions of this project, of Python, and of all packages beside it."""
    packages = {found.metadata["Name"]: found.version for found in distributions()}
    return {"ppaas": __version__, "python": sys.version, "packages": dict(sorted(packages.items()))}


def host() -> dict[str, Any]:
    """Return the system of this computer and what it has of processors, memory and disk."""
    disk = shutil.disk_usage(Path.cwd())
    return {
        "platform": platform.platform(),
        "machine": platform.machine(),
        "cpus": os.cpu_count(),
        "cpus_of_this_process": len(os.sched_getaffinity(0)),
        "load": os.getloadavg(),
        "memory": _lines(MEMORY)[:5],
        "pressure": {file.name: _lines(file) for file in sorted(PRESSURE.glob("*"))},
        "disk": {"free": disk.free, "total": disk.total},
    }


def sizes(folder: Path) -> dict[str, Any]:
    """Return the number and size [bytes] of the files in each part of a data folder, without their content."""
    if not folder.is_dir():
        return {"problem": f"there is no folder {folder}"}
    return {part.name: _size(part) for part in sorted(folder.iterdir())}


def _size(part: Path) -> dict[str, int]:
    files = [part] if part.is_file() else [file for file in part.rglob("*") if file.is_file()]
    return {"files": len(files), "bytes": sum(_length(file) for file in files)}


def _length(file: Path) -> int:
    try:
        return file.lstat().st_size
    except OSError:  # it was removed meanwhile
        return 0


def _lines(file: Path) -> list[str]:
    try:
        return file.read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
