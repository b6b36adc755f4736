"""``ppaas warm``: compile all kernels, so that the first start on this computer and the first plans wait for none."""

import argparse
import subprocess
from pathlib import Path

from ppaas.clock import monotonic
from ppaas.errors import Unavailable

NAME = "warm"
HELP = "compile all kernels of this computer into the cache, before the cloud starts"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "A cloud compiles kernels when it first starts on a computer, which takes some minutes. This command does so "
        "beforehand, for an image or a computer that is being set up, and again after an upgrade. With --wheel it "
        "builds a wheel of them, with which other computers of the same versions compile nothing."
    )
    parser.add_argument("--wheel", metavar="FOLDER", type=Path, help="put a wheel of the compiled kernels there")


def run(arguments: argparse.Namespace) -> int:
    """Compile what is missing, with progress; return the exit status of the compiler.

    Raises
    ------
    Unavailable
        No cache folder can be written, or no wheel can be built.
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
        if arguments.wheel is not None:
            _build_wheel(arguments.wheel)
    return status


def _build_wheel(folder: Path) -> None:
    from engine.runtimes.compilation import kernel_wheel  # noqa: PLC0415  # as above

    print(f"{kernel_wheel.build_wheel(folder)}: install it where kernels are not to be compiled")  # noqa: T201
