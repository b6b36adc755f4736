"""Reading of graphs and layouts of other programs: which format a file has, and its lanes, zones and stations."""

import json
import re

from ppaas.errors import InvalidInput
from ppaas.imports.collection import uncollected
from ppaas.imports.graphs.connectivity import report_connections, report_crossings
from ppaas.imports.graphs.fitting import fitted, report_room
from ppaas.imports.graphs.formats.dxf_lines import read_dxf
from ppaas.imports.graphs.formats.json_text import lenient_json
from ppaas.imports.graphs.formats.lanelet import read_lanelets
from ppaas.imports.graphs.formats.lif import is_layout, lif_graph_of
from ppaas.imports.graphs.formats.nav2_route import is_route_graph, route_graph_of
from ppaas.imports.graphs.model.cleaning import on_map, without_far_places
from ppaas.imports.graphs.model.route_graph import MAX_FILE, NO_OPTIONS, GraphOptions, ReadGraph, moved
from ppaas.imports.graphs.rmf.building import building_graph_of
from ppaas.imports.graphs.rmf.fields import load_yaml
from ppaas.imports.graphs.rmf.nav_graph import is_nav_graph, nav_graph_of
from ppaas.imports.graphs.to_zones import zones_of_graph
from ppaas.imports.report import ImportReport
from ppaas.maps.grid import GridInfo
from ppaas.zones.zone import ZoneSet

FORMATS = (
    "a route graph of Nav2 (GeoJSON), a layout of LIF (JSON), a building or navigation graph of Open-RMF (YAML), a map "
    "of Lanelet2 (OSM XML) or a drawing (DXF)"
)

_DXF = re.compile(rb"^(\s*999[^\n]*\n[^\n]*\n)*\s*0\s*\n\s*SECTION\b")
_BINARY_DXF = b"AutoCAD Binary DXF"


@uncollected()
def import_graph(
    content: bytes, name: str, options: GraphOptions = NO_OPTIONS, info: GridInfo | None = None
) -> tuple[ZoneSet, ImportReport]:
    """Return the lanes, zones and stations of a graph or layout of another program, and what became of its parts.

    Parameters
    ----------
    content : bytes
    name : str
        Name of the file, for people.
    options : GraphOptions
    info : GridInfo, optional
        Grid of the map; what is outside of it is left out.

    Raises
    ------
    InvalidInput
        The file cannot be read at all; the text says why.
    Unavailable
        A library that its format needs is not installed.
    """
    graph, report = read_graph(content, name, options)
    graph = without_far_places(moved(graph, options.shift), report)
    if info is not None:
        graph = on_map(graph, info, report)
    if options.radius is None:
        report_room(graph, report)
    else:
        graph = fitted(graph, options.radius, report)
    report_connections(graph, report)
    report_crossings(graph, report)
    return zones_of_graph(graph, report), report


def read_graph(content: bytes, name: str, options: GraphOptions = NO_OPTIONS) -> ReadGraph:
    """Return the graph of a file, in the frame of the file; see `import_graph`."""
    report = ImportReport(name)
    if len(content) > MAX_FILE:
        raise InvalidInput(f"{name} has {len(content)} bytes; at most {MAX_FILE} are allowed")
    head = content[:4096].lstrip(b"\xef\xbb\xbf \t\r\n")
    if not head:
        raise InvalidInput(f"{name} is empty")
    if content.startswith(_BINARY_DXF) or _DXF.match(content[:4096].lstrip(b"\xef\xbb\xbf")):
        return read_dxf(content, report, options)
    if head.startswith(b"<"):
        return read_lanelets(content, report, options)
    if (
        head.startswith(b"{")
        or content[:2] in (b"\xff\xfe", b"\xfe\xff")
        or json.detect_encoding(content[:4]) != "utf-8"
        or name.lower().endswith("json")
    ):
        return _read_json(content, report, options)
    return _read_yaml(content, report, options)


def _read_json(content: bytes, report: ImportReport, options: GraphOptions) -> ReadGraph:
    tree = lenient_json(content, report)
    if is_layout(tree):
        return lif_graph_of(tree, report, options)
    if is_route_graph(tree):
        return route_graph_of(tree, report, options)
    raise InvalidInput(f"{report.source} is JSON, but no graph: this takes {FORMATS}")


def _read_yaml(content: bytes, report: ImportReport, options: GraphOptions) -> ReadGraph:
    tree = load_yaml(content, report.source)
    if "levels" not in tree:
        raise InvalidInput(f"{report.source} is YAML, but no graph: this takes {FORMATS}")
    return nav_graph_of(tree, report, options) if is_nav_graph(tree) else building_graph_of(tree, report, options)
