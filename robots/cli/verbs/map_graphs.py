"""Verbs ``ppaas map import-graph`` and ``export-graph``: lanes of graphs of other programs, and back."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.bounded import above_zero
from ppaas.clock import epoch
from ppaas.errors import InvalidInput, InvalidZones
from robots.cli.output import print_warnings, show
from robots.cli.output_files import write_file
from robots.cli.session import add_session_arguments, logged_in
from robots.cli.verbs.map_versions import whole_version
from robots.cli.verbs.map_zones import PUBLISHED, check_zones_picture, draw_zones, geojson_of
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from ppaas.imports.graphs.model.route_graph import GraphOptions
    from ppaas.imports.report import ImportReport
    from ppaas.maps.grid import GridInfo, GridMap
    from ppaas.zones.zone import ZoneSet
    from robots.client.rest import RestClient

LIF, NAV2 = (".lif.json", ".lif"), (".geojson",)
"""Endings of files of LIF and of route graphs of Nav2."""

MOST_RADIUS = 10.0
"""Largest radius of robots [m]."""

VEHICLE = "ppaas"
"""Type of the vehicles of layouts that are written."""

CHECKED = ("lanes", "zones", "stations")


def configure(verbs: Any) -> None:
    """Add the parsers of the verbs."""
    taken = verbs.add_parser(
        "import-graph",
        help="make lanes, zones and stations of a graph of Nav2, LIF, Open-RMF, Lanelet2 or DXF",
        description="Lanes and stations of the map are replaced, and zones with the same names; its other zones stay.",
    )
    taken.add_argument("id", metavar="MAP", help="id of the map")
    taken.add_argument("file", type=Path, metavar="FILE", help="GeoJSON, JSON, YAML, OSM XML or DXF")
    taken.add_argument("--dry-run", action="store_true", help="print the report, without a cloud")
    taken.add_argument(
        "--on", type=Path, metavar="MAP.yaml", help="with --dry-run: file of the map, to check the graph against"
    )
    taken.add_argument("--picture", type=Path, metavar="FILE.png", help="draw the lanes, zones and stations on the map")
    _add_choices(taken)
    taken.add_argument("--message", help="reason, stored with the version of the map")
    taken.add_argument("--if-match", metavar="VERSION", help="import only if this is the current version of the map")
    given = verbs.add_parser(
        "export-graph", help="write the lanes of a map as a layout of LIF or a route graph of Nav2"
    )
    given.add_argument("id", metavar="MAP", help="id of the map")
    given.add_argument(
        "--out", type=Path, required=True, metavar="FILE", help="layout of LIF (.lif.json), or route graph (.geojson)"
    )
    given.add_argument("--version", help="those of a version, or a prefix of it (the current one)")
    given.add_argument("--vehicle", default=VEHICLE, metavar="TYPE", help="type of vehicles in a layout (%(default)s)")
    for verb in (taken, given):
        add_session_arguments(verb)


def _add_choices(taken: argparse.ArgumentParser) -> None:
    taken.add_argument("--level", metavar="NAME", help="floor or layout (the reference, or the first with lanes)")
    taken.add_argument("--graph", type=int, metavar="N", help="graph of a building of Open-RMF (the first)")
    taken.add_argument("--vehicle", metavar="TYPE", help="type of the vehicles of a layout of LIF (all)")
    taken.add_argument(
        "--layer", action="append", default=[], metavar="NAME", help="layer of a drawing with lanes; may be repeated"
    )
    taken.add_argument("--scale", type=float, metavar="METRES", help="of a pixel or unit, instead of the file's")
    taken.add_argument(
        "--anchor", type=float, nargs=2, metavar=("LATITUDE", "LONGITUDE"), help="of x = 0, y = 0, for files in degrees"
    )
    taken.add_argument(
        "--shift",
        type=float,
        nargs=3,
        metavar=("X", "Y", "YAW"),
        help="origin of the graph on the map [m, rad] (0 0 0)",
    )
    taken.add_argument(
        "--radius",
        type=above_zero(MOST_RADIUS),
        metavar="M",
        help="of the largest robots [m]: join nodes and leave out edges that are too near to each other for them",
    )


async def import_graph(arguments: argparse.Namespace) -> None:
    """Make zones of a graph, and publish them unless it is a dry run."""
    if arguments.on is not None and not arguments.dry_run:
        raise InvalidInput("--on is the map of a dry run; without --dry-run, it is that of the cloud")
    if arguments.dry_run and arguments.picture is not None and arguments.on is None:
        raise InvalidInput("--picture of a dry run needs the map: give its file with --on MAP.yaml")
    check_zones_picture(arguments.picture)
    if arguments.dry_run:
        _try(arguments)
    else:
        await _publish(arguments)


def _try(arguments: argparse.Namespace) -> None:
    from ppaas.zones.reading import geojson_of as file_of  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from robots.cli.import_report import print_report  # noqa: PLC0415 - see above
    from robots.client.map_files import read_map_file  # noqa: PLC0415 - see above

    grid: GridMap | None = None if arguments.on is None else read_map_file(arguments.on)
    zones, report = _read(arguments, None if grid is None else grid.info)
    print_report(report, as_json=arguments.json)
    if grid is not None and arguments.picture is not None:
        from robots.pictures.map_pictures import write_zones  # noqa: PLC0415 - needs more than the base install

        write_zones(arguments.picture, grid, file_of(zones))
    _check_not_empty(zones, report)
    show(_counts(zones), CHECKED, as_json=arguments.json)


async def _publish(arguments: argparse.Namespace) -> None:
    from ppaas.zones.reading import geojson_of as file_of  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from robots.cli.import_report import print_report  # noqa: PLC0415 - see above

    client, path = logged_in(arguments), path_of("maps", arguments.id)
    described = await client.get(path)
    version = await whole_version(client, arguments.id, arguments.if_match) or described["version"]
    zones, report = _read(arguments, _info(described))
    print_report(report, as_json=arguments.json)
    _check_not_empty(zones, report)
    content = file_of(await _with_others(client, f"{path}/zones", zones))
    message = arguments.message or f"lanes of {arguments.file.name}"
    try:
        answer = await client.put_zones(arguments.id, content, message, version)
    except InvalidZones as error:
        await draw_zones(client, path, arguments.picture, content, error.faults)
        raise
    await draw_zones(client, path, arguments.picture, content)
    show(answer, PUBLISHED, as_json=arguments.json)
    if not arguments.json:
        print_warnings(answer)


def _read(arguments: argparse.Namespace, info: "GridInfo | None") -> tuple["ZoneSet", "ImportReport"]:
    from ppaas.imports.graphs import reading  # noqa: PLC0415 - ``ppaas --help`` loads this module

    try:
        content = arguments.file.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read {arguments.file}: {error.strerror}") from error
    return reading.import_graph(content, arguments.file.name, _options(arguments), info)


def _options(arguments: argparse.Namespace) -> "GraphOptions":
    from ppaas.imports.graphs.model.route_graph import GraphOptions  # noqa: PLC0415 - ``ppaas --help`` loads this module

    return GraphOptions(
        level=arguments.level,
        graph=arguments.graph,
        vehicle=arguments.vehicle,
        layers=tuple(arguments.layer),
        scale=arguments.scale,
        anchor=tuple(arguments.anchor) if arguments.anchor else None,
        radius=arguments.radius,
        shift=tuple(arguments.shift) if arguments.shift else (0.0, 0.0, 0.0),
    )


def _info(described: dict[str, Any]) -> "GridInfo | None":
    """Return the geometry of a map; None if it has no grid."""
    from ppaas.geometry import Pose2D  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from ppaas.maps.grid import GridInfo  # noqa: PLC0415 - see above

    if described.get("resolution") is None:
        return None
    origin = Pose2D(*described["origin"])
    return GridInfo(described["resolution"], described["width"], described["height"], origin)


async def _with_others(client: "RestClient", path: str, zones: "ZoneSet") -> "ZoneSet":
    """Return zones with those of the map that they do not replace."""
    from ppaas.zones.reading import zones_of  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from ppaas.zones.zone import Lane, Station, ZoneSet  # noqa: PLC0415 - see above

    before = zones_of(await geojson_of(client, path))
    names = {zone.name for zone in zones.zones}
    kept = [zone for zone in before.zones if not isinstance(zone.rule, Lane | Station) and zone.name not in names]
    return ZoneSet([*kept, *zones.zones], before.time_zone)


def _check_not_empty(zones: "ZoneSet", report: "ImportReport") -> None:
    if not zones.zones:
        raise InvalidInput(f"{report.source} has no lane and no station that can be imported: see the report")


def _counts(zones: "ZoneSet") -> dict[str, int]:
    lanes, stations = len(zones.lanes), len(zones.stations)
    return {"lanes": lanes, "zones": len(zones.zones) - lanes - stations, "stations": stations}


async def export_graph(arguments: argparse.Namespace) -> None:
    """Write the lanes of a map to a file of another program."""
    from ppaas.imports.graphs.formats.lif_file import Layout, lif_file  # noqa: PLC0415 - see above
    from ppaas.imports.graphs.formats.nav2_route import nav2_route_file  # noqa: PLC0415 - see above
    from ppaas.imports.graphs.from_zones import graph_of_zones  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from ppaas.imports.report import ImportReport  # noqa: PLC0415 - see above
    from ppaas.zones.reading import zones_of  # noqa: PLC0415 - see above
    from robots.cli.import_report import print_report  # noqa: PLC0415 - see above

    name = arguments.out.name.lower()
    if not name.endswith(LIF + NAV2):
        raise InvalidInput(
            f"{arguments.out.name}: a layout of LIF ends with .lif.json, a route graph of Nav2 with .geojson"
        )
    client = logged_in(arguments)
    version = await whole_version(client, arguments.id, arguments.version)
    path = path_of("maps", arguments.id, *(() if version is None else ("versions", version)))
    described = await client.get(path)
    zones = zones_of(await geojson_of(client, f"{path}/zones"))
    report = ImportReport(arguments.id)
    graph = graph_of_zones(zones, report)
    if name.endswith(NAV2):
        content = nav2_route_file(graph, arguments.id)
    else:
        layout = Layout(arguments.id, version or described["version"], arguments.vehicle, epoch())
        content = lif_file(graph, layout, report)
    write_file(arguments.out, content)
    print_report(report, as_json=arguments.json)
