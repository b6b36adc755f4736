"""The kernels that every container uses, compiled on all processors before a fork server loads them, once a computer.

The fork server itself would compile one after the other, and keep what it compiled with in the memory that all
containers share, until it is started again.
"""

import logging
import os
import subprocess
import sys
from pathlib import Path

import ppaas
from engine.processes.disk_notes import exclusive
from engine.processes.parent_watch import end_with
from engine.runtimes.compilation import stamp

logger = logging.getLogger(__name__)

COMMAND = (sys.executable, "-m", __spec__.name)


def compile_missing(layer: str) -> None:
    """Compile the kernels that containers use, unless it is known that they are; call it before any is imported.

    Where it fails that is told, and they are compiled where they are called.

    Parameters
    ----------
    layer : str
        Threading layer that they are compiled for.
    """
    root = Path(ppaas.__path__[0])
    if any(stamp.all_compiled(stamp.stamp_file(root, key)) for key in (_key(layer), layer)):
        return
    done = subprocess.run([*COMMAND, str(os.getpid()), layer], stdin=subprocess.DEVNULL, check=False)
    if done.returncode:
        logger.warning("the compiler of kernels ended with status %d: they are compiled singly", done.returncode)


def main() -> None:
    """Compile them, for a parent, as long as that lives."""
    from engine.runtimes.compilation import compile_pool  # noqa: PLC0415  # no fork server needs it

    parent, layer = sys.argv[1:]
    end_with(int(parent))
    noted = stamp.stamp_file(Path(ppaas.__path__[0]), _key(layer))
    with exclusive(noted.with_suffix(".lock")):
        if not stamp.all_compiled(noted):  # another may just have done it
            stamp.note(noted, compile_pool.compile_all(_names))


def _key(layer: str) -> str:
    return f"{layer}, of containers"


def _names() -> list[str]:
    # So here: with numba, after the choice of its layer.
    from engine.container.warm_up import scripted_session  # noqa: F401, PLC0415
    from engine.container.warm_up.plugins import load_plugins  # noqa: PLC0415
    from engine.runtimes.compilation import kernel_modules  # noqa: PLC0415

    load_plugins()
    return [module.__name__ for module in kernel_modules.loaded()]


if __name__ == "__main__":
    main()
