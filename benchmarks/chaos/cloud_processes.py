"""Processes of a cloud and its machines, recognized by their folder for temporary files."""

from dataclasses import dataclass
from pathlib import Path

import msgspec
import psutil

from endpoints.processes import serving
from engine.agent import main as agent
from engine.fabric import router
from engine.remote import agent as joined_agent
from engine.runtimes.compilation import rest_compiler
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
