"""The processes of a cloud and its machines, told from all others by the folder for temporary files that they have."""

from dataclasses import dataclass
from pathlib import Path

import psutil

from engine.agent import main as agent
from engine.fabric import router
from engine.remote import agent as joined_agent
from engine.runtimes.compilation import rest_compiler
from robots import cli

FORKED = "forkserver"

MACHINES = "machines"
"""Folder of a cloud's folder in which each machine that joined has one by its name."""

OWN = "local"
"""Name of the cloud's own machine."""

_BY_COMMAND = {
    f"{cli.__name__} up": "web",
    joined_agent.__name__: "joined machine",
    agent.__name__: "agent",
    router.__name__: "router",
    rest_compiler.__name__: "compiler",
    "resource_tracker": "resource tracker",
    FORKED: FORKED,
}


@dataclass(frozen=True, slots=True)
class CloudProcessInfo:
    """One process.

    Parameters
    ----------
    process : psutil.Process
        It.
    kind : str
        ``web``, ``agent``, ``joined machine``, ``router``, ``fork server``, ``forked`` (a container, or what makes the
        layers of a map), ``compiler``, ``resource tracker`` or ``other``.
    home : str
        Name of the machine that it belongs to.
    """

    process: psutil.Process
    kind: str
    home: str


def cloud_processes(folder: Path) -> list[CloudProcessInfo]:
    """Return all processes whose folder for temporary files is this one, or lies in it; zombies have none."""
    found = []
    for process in psutil.process_iter():
        try:
            home = Path(process.environ().get("TMPDIR", ""))
            if home.is_relative_to(folder):
                found.append(CloudProcessInfo(process, _kind(process), machine_of(home.relative_to(folder))))
        except psutil.Error:  # it ended just now, or is somebody else's
            continue
    return found


def machine_of(home: Path) -> str:
    """Return the machine that has a folder for temporary files, given below that of the cloud."""
    return home.parts[1] if home.parts[:1] == (MACHINES,) else OWN


def _kind(process: psutil.Process) -> str:
    kind = _kind_of(" ".join(process.cmdline()))
    if kind != FORKED:
        return kind
    parent = process.parent()
    forked = parent is not None and _kind_of(" ".join(parent.cmdline())) == FORKED
    return "forked" if forked else "fork server"


def _kind_of(command: str) -> str:
    return next((kind for words, kind in _BY_COMMAND.items() if words in command), "other")
