"""Verb ``ppaas map merge``: makes one map of two that show the same place, of files or of maps of a cloud."""

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput
from robots.cli.output import show
from robots.cli.output_files import check_folder, write_file
from robots.cli.session import add_session_arguments, logged_in
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from ppaas.mapping.merging.merge import Merged

YAML, POSEGRAPH = (".yaml", ".yml"), ".posegraph"

TIMEOUT = 300.0
"""Time limit of the request [s]; a cloud ends a merge after 240 s."""

COLUMNS = ("id", "version", "width", "height", "motion", "places", "support", "confirmed")
FILE_COLUMNS = ("map", "posegraph", "key_frames", "motion", "places", "support", "confirmed")


def configure(verbs: Any) -> None:
    """Add the parser of the verb."""
    merge = verbs.add_parser(
        "merge",
        help="merge two maps of one place, made by robots without a common start",
        description=(
            "A and B are maps of the cloud, or YAML files with their pose graphs (.posegraph) beside them. The result "
            "is in the frame of A, and is drawn again from the scans of both."
        ),
    )
    merge.add_argument("first", metavar="A", help="map whose frame is kept")
    merge.add_argument("second", metavar="B", help="map that is moved into that frame")
    merge.add_argument("--into", required=True, metavar="C", help="map to publish, or YAML file to write")
    merge.add_argument("--message", help="reason, stored with the version")
    add_session_arguments(merge)


async def merge(arguments: argparse.Namespace) -> None:
    """Merge two maps, and show the result."""
    files = [is_file(name) for name in (arguments.first, arguments.second, arguments.into)]
    if len(set(files)) > 1:
        raise InvalidInput("merge maps of the cloud, or files: give A, B and C all as ids, or all as .yaml files")
    if files[0]:
        show(_merge_files(arguments), FILE_COLUMNS, as_json=arguments.json)
    else:
        show(await _merge_published(arguments), COLUMNS, as_json=arguments.json)


def is_file(name: str) -> bool:
    """Return whether an argument names a file, by its ending."""
    return name.endswith((*YAML, POSEGRAPH))


async def _merge_published(arguments: argparse.Namespace) -> dict[str, Any]:
    body = {"with": arguments.second, "into": arguments.into, "message": arguments.message or ""}
    client = logged_in(arguments).with_timeout(TIMEOUT)
    with _progress(f"merge {arguments.first} and {arguments.second}"):
        answer: dict[str, Any] = await client.post(path_of("maps", arguments.first, "merge"), body)
    return answer


def _merge_files(arguments: argparse.Namespace) -> dict[str, Any]:
    """Merge pose graphs in files; write the files of the map and return the answer."""
    from ppaas.mapping.merging.merged_files import merge_files  # noqa: PLC0415 - ``ppaas --help`` loads this module

    into = Path(arguments.into)
    if into.suffix not in YAML:
        raise InvalidInput(f"a map is a YAML file; use --into {into.stem or 'map'}.yaml")
    check_folder(into)
    first, second = (_graph(Path(name)) for name in (arguments.first, arguments.second))
    image, graph = into.with_suffix(".pgm"), into.with_suffix(POSEGRAPH)
    with _progress(f"merge {arguments.first} and {arguments.second}") as done:
        found = merge_files(first, second, image.name, _resolution(Path(arguments.first)), done)
    write_file(graph, b"".join(found.posegraph))
    write_file(image, found.image)
    write_file(into, found.yaml)
    return {"map": str(into), "posegraph": str(graph), **_summary(found.merged)}


def _summary(merged: "Merged") -> dict[str, Any]:
    return {
        "key_frames": len(merged.mapping.frames),
        "motion": [round(float(value), 4) for value in merged.motion],
        "places": merged.matches,
        "support": round(merged.support, 3),
        "confirmed": round(merged.confirmed, 4),
    }


def _graph(path: Path) -> bytes:
    file = path.with_suffix(POSEGRAPH)
    try:
        return file.read_bytes()
    except OSError as error:
        raise InvalidInput(
            f"cannot read the pose graph of {path}: {error}; make one with 'ppaas slam LOG --map {path.stem}.yaml "
            f"--posegraph {file.name}', or fetch it with 'ppaas map fetch'"
        ) from error


def _resolution(path: Path) -> float:
    """Return the edge of the cells of a map in a file [m]; the default if only its pose graph is given."""
    from ppaas.mapping.map_drawing import DEFAULTS  # noqa: PLC0415
    from ppaas.maps.formats.map_yaml import parse_yaml  # noqa: PLC0415

    if path.suffix not in YAML:
        return DEFAULTS.resolution
    try:
        return float(parse_yaml(path.read_bytes()).resolution)
    except OSError as error:
        raise InvalidInput(f"cannot read the map: {error}") from error


@contextmanager
def _progress(name: str) -> Iterator[Callable[[int, int], None]]:
    """Show the progress on a terminal; a moving bar until the first report."""
    from rich.console import Console  # noqa: PLC0415 - a robot's install lacks rich
    from rich.progress import Progress  # noqa: PLC0415

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task(name, total=None)
        yield lambda done, of: progress.update(task, completed=done, total=of)
