"""``ppaas warm``: compile all kernels, so that the first start on this computer and the first plans wait for none."""

import argparse
import subprocess

from ppaas.clock import monotonic
from ppaas.errors import Unavailable

NAME = "warm"
HELP = "compile all kernels of this computer into the cache, before the cloud starts"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "A cloud compiles kernels when it first starts on a computer, which takes some minutes. This command does so "
        "beforehand, for an image or a computer that is being set up. Kernels are compiled for the processor of this "
        "computer, and again after an upgrade."
    )


def run(_arguments: argparse.Namespace) -> int:
    """Compile what is missing, with progress; return the exit status of the compiler.

    Raises
    ------
    Unavailable
        No cache folder can be written.
    """
    # Imported here: ``ppaas --help`` loads this module.
    from engine.runtimes.compilation import cache_folder, rest_compiler  # noqa: PLC0415

    if not cache_folder.is_writable():
        raise Unavailable(
            f"no folder for compiled kernels can be written: set {cache_folder.VARIABLE} to one that can be"
        )
    began = monotonic()
    status = subprocess.run(rest_compiler.COMMAND, check=False).returncode
    if status == 0:
        print(f"all kernels are compiled, after {monotonic() - began:.0f} s")  # noqa: T201
    return status
