"""First start on a host: compiles the kernels that every container uses, on all processors, into the cache.

It runs in another process, before the fork server loads the kernels. The fork server would compile them one after
another, and the compiler would stay in the memory that all containers share.
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
    """Compile the kernels that containers use, unless the cache is complete; call it before any is imported.

    A failure is logged, and each kernel is compiled at its first call.

    Parameters
    ----------
    layer : str
        Name of numba's threading layer for which they are compiled.
    """
    root = Path(ppaas.__path__[0])
    if any(stamp.all_compiled(stamp.stamp_file(root, key)) for key in (_key(layer), layer)):
        return
    done = subprocess.run([*COMMAND, str(os.getpid()), layer], stdin=subprocess.DEVNULL, check=False)
    if done.returncode:
        logger.warning(
            "the kernel compiler exited with status %d: each kernel is compiled at its first call", done.returncode
        )


def main() -> None:
    """Compile the kernels; exit if the parent process dies."""
    from engine.runtimes.compilation import compile_pool  # noqa: PLC0415  # fork servers do not need it

    parent, layer = sys.argv[1:]
    end_with(int(parent))
    noted = stamp.stamp_file(Path(ppaas.__path__[0]), _key(layer))
    with exclusive(noted.with_suffix(".lock")):
        if not stamp.all_compiled(noted):  # another process may have done it meanwhile
            stamp.note(noted, compile_pool.compile_all(_names))


def _key(layer: str) -> str:
    return f"{layer}, of containers"


def _names() -> list[str]:
    # Imported here: they import numba, whose threading layer must be chosen first.
    from engine.container.warm_up import scripted_session  # noqa: F401, PLC0415
    from engine.container.warm_up.plugins import load_plugins  # noqa: PLC0415
    from engine.runtimes.compilation import kernel_modules  # noqa: PLC0415

    load_plugins()
    return [module.__name__ for module in kernel_modules.loaded()]


if __name__ == "__main__":
    main()
