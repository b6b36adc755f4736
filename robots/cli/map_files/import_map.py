"""Verbs ``ppaas map import`` and ``ppaas map from-plan``: make maps of files of other programs."""

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput
from robots.cli.map_files.publication import add_publication_arguments, publish
from robots.cli.output import print_line
from robots.cli.output_files import write_file
from robots.cli.session import add_session_arguments

if TYPE_CHECKING:
    from ppaas.imports.maps.common.imported_map import ImportedMap
    from ppaas.imports.report import ImportReport
    from ppaas.maps.georeference import GeoAnchor

_WORLD_ENDINGS = (".wld", ".pgw", ".pngw", ".jgw", ".jpgw", ".jpegw", ".tfw", ".tifw", ".bpw")
MAX_FILE = 2 << 30
"""Limit of the size of a file [bytes]: the most points that are read have less in any format but text."""

_VALUES = ("greys", "occupancies", "mask", "heights")


def configure(verbs: Any) -> None:
    """Add the parsers of the verbs."""
    one = verbs.add_parser(
        "import",
        help="make a map of a file of another program: vacuum robots, mowers, point clouds, GIS",
        description=(
            "Reads maps of Valetudo and OpenMower (JSON), point clouds (PCD, PLY, LAS, LAZ, E57, text), GeoTIFF, ESRI "
            "ASCII grids, and pictures with a world file. Prints what became of each part, and publishes the map."
        ),
    )
    one.add_argument("file", type=Path)
    one.add_argument("--resolution", type=_positive, metavar="METRES", help="edge of a cell (suits the file)")
    one.add_argument(
        "--heights", type=_numbers(2), default=(0.15, 1.5), metavar="LOW,HIGH",
        help="heights above the floor at which points are obstacles [m] (0.15,1.5)",
    )  # fmt: skip
    one.add_argument("--up", choices=("z", "y"), default="z", help="axis of a point cloud that points up (z)")
    one.add_argument("--unit", type=_positive, default=1.0, metavar="METRES", help="of a point cloud (1)")
    one.add_argument("--floor", type=float, metavar="Z", help="height of the floor in a point cloud [m] (found)")
    one.add_argument("--max-slope", type=_positive, default=15.0, metavar="DEGREES", help="of heights (15)")
    one.add_argument("--values", choices=_VALUES, help="meaning of the pixels of a raster (found)")
    _add_common(one)
    plan = verbs.add_parser(
        "from-plan",
        help="make a map of a floor plan: picture, SVG, DXF or page of a PDF",
        description="Walls are what is drawn dark. Two points of the plan and their distance give its scale.",
    )
    plan.add_argument("file", type=Path)
    plan.add_argument(
        "--scale-by", type=_numbers(5), metavar="X1,Y1,X2,Y2,METRES",
        help="two points in the units of the file, from its upper left corner (DXF: its own), and their distance",
    )  # fmt: skip
    plan.add_argument("--resolution", type=_positive, default=0.05, metavar="METRES", help="edge of a cell (0.05)")
    plan.add_argument("--dark", type=int, default=128, metavar="GREY", help="grey below which a pixel is a wall (128)")
    plan.add_argument("--thinnest", type=_positive, default=0.0, metavar="METRES", help="thinner lines are no walls")
    plan.add_argument("--page", type=int, default=1, help="page of a PDF (1)")
    plan.add_argument("--layer", action="append", metavar="NAME", help="layer of a DXF that has walls (all but others)")
    plan.add_argument("--outside-free", action="store_true", help="cells that no walls enclose are free, too")
    _add_common(plan)


def _add_common(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--start", type=_numbers(2), metavar="X,Y", help="a free place within walls [m]")
    parser.add_argument(
        "--anchor", type=_numbers(2, 3), metavar="LAT,LON[,YAW]",
        help="georeference of the map's origin [°], and the angle from east to its x axis [rad]",
    )  # fmt: skip
    parser.add_argument("--dry-run", action="store_true", help="print the report, and publish nothing")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="write the files of the map, and publish nothing")
    parser.add_argument("--picture", type=Path, metavar="FILE.png", help="draw the map; a plan, too, beside it")
    add_publication_arguments(parser)
    add_session_arguments(parser)


# -- verbs -------------------------------------------------------------------------------------------------------------


async def import_map_file(arguments: argparse.Namespace) -> None:
    """Import a map, and publish it."""
    # ``ppaas --help`` loads this module, and imports need more than the base install.
    from ppaas.imports.maps.common.imported_map import MapOptions  # noqa: PLC0415
    from robots.client.foreign_maps import import_foreign_map  # noqa: PLC0415

    file = arguments.file
    options = MapOptions(
        resolution=arguments.resolution, heights=arguments.heights, floor=arguments.floor,
        up=arguments.up, unit=arguments.unit, start=arguments.start, anchor=_anchor(arguments),
        max_slope=arguments.max_slope, values=arguments.values, world=_beside(file, *_WORLD_ENDINGS),
        projection=_beside(file, ".prj"),
    )  # fmt: skip
    _check(arguments)
    imported, report = import_foreign_map(_read(file), file.name, options)
    await _deliver(arguments, imported, report, None)


async def from_plan(arguments: argparse.Namespace) -> None:
    """Import a floor plan, and publish it as a map."""
    from ppaas.imports.maps.drawings.plan_import import import_plan  # noqa: PLC0415 - see above
    from ppaas.imports.maps.drawings.plan_picture import PlanOptions, ScaleBar  # noqa: PLC0415

    scale = None
    if arguments.scale_by is not None:
        ax, ay, bx, by, metres = arguments.scale_by
        scale = ScaleBar((ax, ay), (bx, by), metres)
    options = PlanOptions(
        scale=scale, resolution=arguments.resolution, dark=arguments.dark, thinnest=arguments.thinnest,
        page=arguments.page, layers=tuple(arguments.layer or ()), start=arguments.start,
        outside_is_free=arguments.outside_free,
    )  # fmt: skip
    _check(arguments)
    imported, report, drawn = import_plan(_read(arguments.file), arguments.file.name, options)
    await _deliver(arguments, imported.anchored(_anchor(arguments)), report, drawn)


def _check(arguments: argparse.Namespace) -> None:
    """Check names of files before long work."""
    if arguments.picture is not None:
        from robots.pictures.path import check_picture  # noqa: PLC0415 - pictures need more than the base install

        check_picture(arguments.picture)


async def _deliver(arguments: argparse.Namespace, imported: "ImportedMap", report: "ImportReport", drawn: Any) -> None:
    """Print the report; draw, write or publish the map."""
    from ppaas.imports.maps.common.imported_map import files_of  # noqa: PLC0415 - see above
    from robots.cli.import_report import print_report  # noqa: PLC0415
    from robots.client.map_files import map_id_of  # noqa: PLC0415
    from robots.pictures.imported_map import write_imported  # noqa: PLC0415

    print_report(report, as_json=arguments.json)
    if arguments.picture is not None:
        write_imported(arguments.picture, imported, drawn)
    if arguments.dry_run:
        return
    map_id = arguments.id or map_id_of(arguments.file)
    files = files_of(imported, f"{map_id}.pgm")
    if arguments.out is None:
        await publish(arguments, map_id, files.yaml, files.image, octomap=files.octomap, zones=files.zones)
        return
    parts = {".pgm": files.image, ".bt": files.octomap, ".zones.geojson": files.zones, ".yaml": files.yaml}
    try:
        arguments.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(f"cannot write to {arguments.out}: {error}") from error
    for ending, content in parts.items():
        if content is not None:
            path = arguments.out / f"{map_id}{ending}"
            write_file(path, content)
            print_line(str(path))


# -- arguments and files -----------------------------------------------------------------------------------------------


def _read(file: Path) -> bytes:
    try:
        size = file.stat().st_size
        if size > MAX_FILE:
            raise InvalidInput(f"{file.name} has {size} bytes; at most {MAX_FILE} are allowed")
        return file.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read the map: {error}") from error


def _beside(file: Path, *endings: str) -> bytes | None:
    """Return the content of the file with the same name and one of these endings, if there is one."""
    for ending in endings:
        for path in (file.with_suffix(ending), file.with_suffix(ending.upper())):
            if path.is_file():
                return _read(path)
    return None


def _anchor(arguments: argparse.Namespace) -> "GeoAnchor | None":
    from ppaas.maps.georeference import GeoAnchor  # noqa: PLC0415 - ``ppaas --help`` loads this module

    return None if arguments.anchor is None else GeoAnchor(*arguments.anchor)


def _positive(text: str) -> float:
    value = float(text)
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"must be a positive number, not {text}")
    return value


def _numbers(*counts: int) -> Callable[[str], tuple[float, ...]]:
    """Return a parser of numbers with commas between them, of which there must be as many."""

    def parsed(text: str) -> tuple[float, ...]:
        numbers = tuple(float(part) for part in text.split(","))
        if len(numbers) not in counts or not all(map(math.isfinite, numbers)):
            wanted = " or ".join(map(str, counts))
            raise argparse.ArgumentTypeError(f"must be {wanted} numbers with commas between them, not {text}")
        return numbers

    return parsed
