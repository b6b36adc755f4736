"""``ppaas warm``: compile all kernels, so that the first start on this computer and the first plans wait for none."""

import argparse
import json
import subprocess
import sys
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
    parser.add_argument("--json", action="store_true", help="print the result as JSON; progress on standard error")
    parser.add_argument("--wheel", metavar="FOLDER", type=Path, help="put a wheel of the compiled kernels there")


def run(arguments: argparse.Namespace) -> int:
    """Compile what is missing, with progress; return the exit status of the compiler.

    Raises
    ------
    Unavailable
        No cache folder can be written, or no wheel can be built.
    """
    # Imported here: ``ppaas --help`` loads this module.
    from engine.runtimes.compilation import cache_folder, kernel_wheel, rest_compiler  # noqa: PLC0415

    if not cache_folder.is_writable():
        raise Unavailable(
            f"no folder for compiled kernels can be written: set {cache_folder.VARIABLE} to one that can be"
        )
    began = monotonic()
    command = subprocess.run(rest_compiler.COMMAND, check=False, stdout=sys.stderr if arguments.json else None)
    if command.returncode != 0:
        return command.returncode
    seconds = monotonic() - began
    if not arguments.json:
        print(f"all kernels are compiled, after {seconds:.0f} s")  # noqa: T201
    wheel = None if arguments.wheel is None else kernel_wheel.build_wheel(arguments.wheel)
    if arguments.json:
        print(json.dumps({"seconds": round(seconds, 3), "wheel": None if wheel is None else str(wheel)}))  # noqa: T201
    elif wheel is not None:
        print(f"{wheel}: install it where kernels are not to be compiled")  # noqa: T201
    return 0
