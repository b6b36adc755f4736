"""A planner that plans nothing: it looks for whatever belongs to others, and tells what it found as its error."""

import json
import os
import socket
from pathlib import Path
from typing import Any

import numba

from ppaas.errors import NoValidPath
from ppaas.planners.base import Planner

OTHERS = "secret-of-bob"
"""In the name of what another user has."""

OWN = ("/opt", "/usr", "/lib", "/sys", "/proc")
"""Where everybody's programs are, and what the kernel shows; the latter is looked at in its own way."""

TO_WRITE = ("/", "/run/map", "/run/ppaas", "/opt/ppaas")

OUTSIDE = [("127.0.0.1", 8500), ("172.17.0.1", 22), ("192.0.2.1", 80)]


def findings() -> dict[str, Any]:
    """Return what a plug-in reaches from where it runs."""
    status = dict(line.split(":\t", 1) for line in Path("/proc/self/status").read_text().splitlines() if ":\t" in line)
    return {
        "user": os.getuid(),
        "capabilities": int(status["CapEff"], 16),
        "no_new_privileges": status["NoNewPrivs"],
        "of_others": _of_others(),
        "sockets": sorted(path for path in _files() if Path(path).is_socket()),
        "processes": [name for name in _processes() if _read(f"/proc/{name}/environ")],
        "reached": [str(address) for address in OUTSIDE if _can(lambda to=address: socket.create_connection(to, 0.3))],
        "interfaces": [name for _, name in socket.if_nameindex()],
        "wrote": [folder for folder in TO_WRITE if _can(lambda at=folder: _write(at))],
        "threads": numba.get_num_threads(),
        "became_root": _can(lambda: os.setuid(0)),
    }


def _of_others() -> list[str]:
    """Return the paths that name what another has, and the processes that know of it."""
    shown = [path for path in _files() if OTHERS in path]
    known = {name: _read(f"/proc/{name}/environ") + _read(f"/proc/{name}/maps") for name in _processes()}
    return shown + [name for name, text in known.items() if OTHERS.encode() in text]


def _files() -> list[str]:
    found = []
    for folder, folders, files in os.walk("/"):
        folders[:] = [name for name in folders if not str(Path(folder, name)).startswith(OWN)]
        found += [str(Path(folder, name)) for name in (*folders, *files)]
    return found


def _processes() -> list[str]:
    return [entry.name for entry in Path("/proc").iterdir() if entry.name.isdecimal()]


def _read(path: str) -> bytes:
    try:
        return Path(path).read_bytes()
    except OSError:
        return b""


def _write(folder: str) -> None:
    Path(folder, "mine").write_text("mine")
    Path(folder, "mine").unlink()


def _can(attempt: Any) -> bool:
    try:
        attempt()
    except OSError:
        return False
    return True


class Hostile(Planner):
    """Looks around instead of planning."""

    name = "hostile"
    purpose = "reads what belongs to others"

    def plan(self, costmap: Any, request: Any) -> Any:
        raise NoValidPath(json.dumps(findings()))


class Curious(Hostile):
    """The same by another name, which no admin has allowed."""

    name = "curious"
