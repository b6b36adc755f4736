"""Main program of a Docker container.

``python -m engine.runtimes.docker.entry [MODULE…] ENTRY`` imports everything in advance, as a fork server does: it is a
*spare*. Then it dials the machine and waits for its ``Launch``. This module does not load numpy: the first of the
modules sets its threads.
"""

import importlib
import os
import shutil
import socket
import sys

from engine.runtimes.fork_server.child import die_with, resolve, set_up
from ppaas.decoding import from_json

FOLDER = "/run/ppaas"
"""Folder of the sockets that this container may dial."""

START, LINK, MACHINE = "start.sock", "link.sock", "gate.sock"

LAYERS = "/run/map"
"""Folder of the layers of its map."""

KERNELS, OWN_KERNELS = "NUMBA_CACHE_DIR", "/tmp/kernels"


def main(arguments: list[str]) -> int | None:
    """Import the modules, wait for the launch and run ``ENTRY``; its result becomes the exit status."""
    _link_kernels()
    *modules, function = arguments
    for module in modules:
        importlib.import_module(module)
    entry = resolve(function)
    from engine.specs.containers import Launch  # noqa: PLC0415 - it loads numpy

    with socket.socket(socket.AF_UNIX) as machine:
        machine.connect(f"{FOLDER}/{START}")
        with machine.makefile("rb") as orders:
            order = orders.readline()
        if not order:
            return os.EX_OK  # the agent has exited and needs no container
        launch = from_json(order, Launch)
        die_with(machine.fileno())
        set_up(launch)
        return entry(launch)


def _link_kernels() -> None:
    """Give numba a writable cache folder with links to the kernels of the image, which is read-only.

    Kernels that are compiled here are kept in memory only, until the container ends.
    """
    shutil.copytree(os.environ[KERNELS], OWN_KERNELS, copy_function=os.symlink)
    os.environ[KERNELS] = OWN_KERNELS


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
