"""``ppaas bench imports``: imports the files of other programs, and lets robots drive by what they became."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "files of other programs: time and report of their imports, and whether a robot then drives"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "paths", nargs="*", type=Path, metavar="PATH", help="files, and folders of files; without any: generated files"
    )
    parser.add_argument(
        "--large", action="store_true", help="generate files of 10 MB, in place of small ones, and do not drive"
    )
    parser.add_argument("--no-drive", dest="drive", action="store_false", help="import only")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Import each file, and drive by it; return a row for each."""
    # ``ppaas bench --help`` loads this module.
    from benchmarks.imports.run import ImportsReport, try_file  # noqa: PLC0415
    from benchmarks.imports.samples import samples  # noqa: PLC0415

    files = [(path.name, path.read_bytes()) for path in _files(arguments.paths)]
    if not arguments.paths:
        files = samples(large=arguments.large)
    task = progress.add_task(f"{len(files)} files", total=len(files))
    tried = []
    for name, content in files:
        tried.append(try_file(name, content, drives=arguments.drive and not arguments.large))
        progress.advance(task)
    return Measured.of(ImportsReport(tried))


def _files(paths: list[Path]) -> list[Path]:
    found = []
    for path in paths:
        inside = sorted(each for each in path.rglob("*") if each.is_file()) if path.is_dir() else [path]
        found += [each for each in inside if each.name != "README.md"]
    return found
