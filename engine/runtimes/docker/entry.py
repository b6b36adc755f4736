"""A container of a runtime that has images, from its first moment.

``python -m engine.runtimes.docker.entry [MODULE…] ENTRY`` loads everything, as a fork server does, though nobody has
asked for it yet: it is a *spare*. Then it dials the machine and waits to be told what it is.
"""

import importlib
import os
import shutil
import socket
import sys

import msgspec

from engine.runtimes.fork_server.child import die_with, resolve, settle
from engine.specs.containers import Launch

FOLDER = "/run/ppaas"
"""Where the sockets are that a container may dial, its own alone."""

START, LINK, MACHINE = "start.sock", "link.sock", "gate.sock"

LAYERS = "/run/map"
"""Where the layers of its map are."""


KERNELS, OWN_KERNELS = "NUMBA_CACHE_DIR", "/tmp/kernels"


def main(arguments: list[str]) -> int | None:
    """Get ready, be told, and be the container: what ``ENTRY`` returns becomes the exit status."""
    _take_kernels()
    *modules, function = arguments
    for module in modules:
        importlib.import_module(module)
    entry = resolve(function)
    with socket.socket(socket.AF_UNIX) as machine:
        machine.connect(f"{FOLDER}/{START}")
        with machine.makefile("rb") as orders:
            told = orders.readline()
        if not told:
            return os.EX_OK  # the machine has gone, and needs nobody
        launch = msgspec.json.decode(told, type=Launch)
        die_with(machine.fileno())
        settle(launch)
        return entry(launch)


def _take_kernels() -> None:
    """Let numba find the kernels of the image, whose folder it would not take: it is one that cannot be written to.

    What is compiled here goes beside them in memory, and is gone with the container.
    """
    shutil.copytree(os.environ[KERNELS], OWN_KERNELS, copy_function=os.symlink)
    os.environ[KERNELS] = OWN_KERNELS


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
