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
from engine.processes.helper_program import end_with
from engine.runtimes.compilation import stamp

logger = logging.getLogger(__name__)

COMMAND = (sys.executable, "-W", stamp.QUIET, "-m", __spec__.name)

ATTEMPTS = 3
"""Number of compilers that are started, one after the other, if each is killed."""


def compile_missing(layer: str) -> None:
    """Compile the kernels that containers use, unless the cache is complete; call it before any is imported.

    A compiler that is killed is started again, `ATTEMPTS` times in all; it continues with what is missing. After a
    failure, which is logged, each kernel is compiled at its first call.

    Parameters
    ----------
    layer : str
        Name of numba's threading layer for which they are compiled.
    """
    root = Path(ppaas.__path__[0])
    if any(stamp.is_compiled(root, key) for key in (_key(layer), layer)):
        return
    for _ in range(ATTEMPTS):
        done = subprocess.run([*COMMAND, str(os.getpid()), layer], stdin=subprocess.DEVNULL, check=False)
        if done.returncode >= 0:
            break
        logger.warning("the kernel compiler was killed by signal %d", -done.returncode)
    if done.returncode:
        logger.warning(
            "the kernel compiler exited with status %d: each kernel is compiled at its first call", done.returncode
        )


def main() -> None:
    """Compile the kernels; exit if the parent process dies."""
    # Imported here: fork servers do not need them.
    from engine.runtimes.compilation import compile_pool  # noqa: PLC0415
    from engine.runtimes.compilation.stamp import ModuleNotes  # noqa: PLC0415

    parent, layer = sys.argv[1:]
    end_with(int(parent))
    root = Path(ppaas.__path__[0])
    noted = stamp.stamp_file(root, _key(layer))
    if not stamp.is_compiled(root, _key(layer)):
        stamp.note(noted, compile_pool.compile_all(_names, ModuleNotes(stamp.stamp_file(root, layer))))


def _key(layer: str) -> str:
    return f"{layer}, of containers"


def _names() -> list[str]:
    # Imported here: they import numba, whose threading layer must be chosen first.
    from engine.container.warm_up import scripted_session  # noqa: F401, PLC0415
    from engine.container.warm_up.plugins import load_plugins  # noqa: PLC0415
    from engine.runtimes.compilation import kernel_modules  # noqa: PLC0415

    # Not loaded beforehand, but called by containers that plan for programs, and by endpoints that answer these.
    from ppaas.planners.kernels import pose_text  # noqa: F401, PLC0415
    from ppaas.plans.encoding import codes  # noqa: F401, PLC0415

    load_plugins()
    return [module.__name__ for module in kernel_modules.loaded()]


if __name__ == "__main__":
    main()
