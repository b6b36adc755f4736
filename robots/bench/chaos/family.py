"""The processes of a cloud and its machines, told from all others by the folder for temporary files that they have."""

from dataclasses import dataclass
from pathlib import Path

import psutil

FORKED = "forkserver"

_BY_COMMAND = {
    "endpoints.cli up": "web",
    "engine.joined": "joined machine",
    "engine.agent": "agent",
    "engine.router": "router",
    "engine.runtimes.rest_compiler": "compiler",
    "resource_tracker": "resource tracker",
    FORKED: FORKED,
}


@dataclass(frozen=True, slots=True)
class Member:
    """One process.

    Parameters
    ----------
    process : psutil.Process
        It.
    kind : str
        ``web``, ``agent``, ``joined machine``, ``router``, ``fork server``, ``forked`` (a container, or what makes the
        layers of a map), ``compiler``, ``resource tracker`` or ``other``.
    home : str
        Name of the folder for temporary files, which each machine has for itself.
    """

    process: psutil.Process
    kind: str
    home: str


def members(folder: Path) -> list[Member]:
    """Return all processes whose folder for temporary files is this one, or lies in it; zombies have none."""
    found = []
    for process in psutil.process_iter():
        try:
            home = process.environ().get("TMPDIR", "")
            if home == str(folder) or home.startswith(f"{folder}/"):
                found.append(Member(process, _kind(process), Path(home).name))
        except psutil.Error:  # it ended just now, or is somebody else's
            continue
    return found


def _kind(process: psutil.Process) -> str:
    kind = _kind_of(" ".join(process.cmdline()))
    if kind != FORKED:
        return kind
    parent = process.parent()
    forked = parent is not None and _kind_of(" ".join(parent.cmdline())) == FORKED
    return "forked" if forked else "fork server"


def _kind_of(command: str) -> str:
    return next((kind for words, kind in _BY_COMMAND.items() if words in command), "other")
