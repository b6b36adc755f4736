"""Verb ``ppaas building import``: makes maps, zones and the record of all floors of a building of Open-RMF."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.bounded import above_zero
from ppaas.errors import InvalidInput
from robots.cli.output import print_line, print_warnings, show
from robots.cli.session import add_session_arguments, logged_in

if TYPE_CHECKING:
    from ppaas.imports.buildings.rmf_building import ImportedBuilding
    from ppaas.imports.report import ImportReport

ENDING = ".building.yaml"

MOST_RADIUS = 10.0
"""Largest radius of robots [m]."""

MADE = ("name", "map", "elevation", "anchor")
"""Columns of the floors of a dry run."""


def configure(verbs: Any) -> None:
    """Add the parser of the verb."""
    taken = verbs.add_parser(
        "import",
        help="make maps, zones and a building of all floors of a .building.yaml of Open-RMF",
        description=(
            "Each floor becomes a map, of its drawing if that is beside the file, else of its walls. Prints what "
            "became of each part, publishes the maps with their zones, and puts the building."
        ),
    )
    taken.add_argument("file", type=Path, metavar=f"FILE{ENDING}")
    taken.add_argument("--id", help="id of the building, with which the ids of its maps begin (name of the file)")
    taken.add_argument("--dry-run", action="store_true", help="print the report, without a cloud")
    taken.add_argument("--picture", type=Path, metavar="FILE.png", help="draw all floors side by side")
    taken.add_argument(
        "--resolution", type=above_zero(1.0), default=0.05, metavar="METRES", help="edge of a cell (0.05)"
    )
    taken.add_argument("--graph", type=int, metavar="N", help="graph of the lanes (the first of each floor)")
    taken.add_argument("--scale", type=float, metavar="METRES", help="of a pixel, instead of the measurements")
    taken.add_argument(
        "--anchor", type=float, nargs=2, metavar=("LATITUDE", "LONGITUDE"), help="of x = 0, y = 0, for files in degrees"
    )
    taken.add_argument(
        "--radius", type=above_zero(MOST_RADIUS), metavar="M",
        help="of the largest robots [m]: join nodes and leave out edges that are too near to each other for them",
    )  # fmt: skip
    taken.add_argument("--reader", action="append", default=[], help="another user who may use its maps")
    taken.add_argument("--message", help="reason, stored with the versions")
    add_session_arguments(taken)


async def import_building_file(arguments: argparse.Namespace) -> None:
    """Import a building, and put it unless it is a dry run."""
    if arguments.picture is not None:
        from robots.pictures.path import check_picture  # noqa: PLC0415 - pictures need more than the base install

        check_picture(arguments.picture)
    building_id = arguments.id or _id_of(arguments.file)
    found, report = _imported(arguments, building_id)
    from robots.cli.import_report import print_report  # noqa: PLC0415 - ``ppaas --help`` loads this module

    print_report(report, as_json=arguments.json)
    if arguments.picture is not None:
        _draw(arguments.picture, found)
    if arguments.dry_run:
        _show_dry(found, as_json=arguments.json)
    else:
        await _publish(arguments, building_id, found)


def _id_of(file: Path) -> str:
    from robots.client.map_files import map_id_of  # noqa: PLC0415 - ``ppaas --help`` loads this module

    return map_id_of(Path(file.name.removesuffix(ENDING)).with_suffix(""))


def _imported(arguments: argparse.Namespace, building_id: str) -> tuple["ImportedBuilding", "ImportReport"]:
    # ``ppaas --help`` loads this module, and imports need more than the base install.
    from ppaas.imports.buildings.rmf_building import drawings_of, import_building  # noqa: PLC0415
    from ppaas.imports.graphs.model.route_graph import GraphOptions  # noqa: PLC0415

    file: Path = arguments.file
    try:
        content = file.read_bytes()
        drawings = {
            level: path.read_bytes()
            for level, name in drawings_of(content, file.name).items()
            if (path := file.parent / name).is_file()
        }
    except OSError as error:
        raise InvalidInput(f"cannot read the building: {error}") from error
    options = GraphOptions(
        graph=arguments.graph, scale=arguments.scale, radius=arguments.radius,
        anchor=tuple(arguments.anchor) if arguments.anchor else None,
    )  # fmt: skip
    return import_building(content, file.name, building_id, drawings, resolution=arguments.resolution, options=options)


def _draw(picture: Path, found: "ImportedBuilding") -> None:
    from ppaas.zones.reading import geojson_of  # noqa: PLC0415 - see above
    from robots.pictures.floors import FloorPicture, write_floors  # noqa: PLC0415

    floors = [FloorPicture(name, each.grid, geojson_of(each.zones)) for name, each in found.maps.items()]
    write_floors(picture, floors)


def _show_dry(found: "ImportedBuilding", *, as_json: bool) -> None:
    import msgspec  # noqa: PLC0415 - see above

    made = msgspec.to_builtins(found.building)
    if as_json:
        print_line(msgspec.json.encode({"building": made, "warnings": found.warnings}).decode())
        return
    show([msgspec.structs.asdict(floor) | {"anchor": list(floor.anchor)} for floor in found.building.floors], MADE,
         as_json=False)  # fmt: skip
    print_warnings({"warnings": found.warnings})


async def _publish(arguments: argparse.Namespace, building_id: str, found: "ImportedBuilding") -> None:
    """Publish the maps, and put the building; it can be repeated if it was interrupted."""
    from ppaas.buildings.building import json_of  # noqa: PLC0415 - see above
    from ppaas.imports.maps.common.imported_map import files_of  # noqa: PLC0415

    client = logged_in(arguments)
    message = arguments.message or f"floors of {arguments.file.name}"
    for floor in found.building.floors:
        files = files_of(found.maps[floor.name], f"{floor.map}.pgm")
        await client.upload_map(
            floor.map, files.yaml, files.image, tuple(arguments.reader), zones=files.zones, message=message
        )
    answer = await client.put_building(building_id, json_of(found.building), message)
    show(answer, ("id", "owner", "version", "floors"), as_json=arguments.json)
    if not arguments.json:
        print_warnings(answer)
