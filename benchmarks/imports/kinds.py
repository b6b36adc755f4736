"""Kinds of files that are imported: how each is known, imported, parsed barely, and driven by."""

import io
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgspec
import yaml

from benchmarks.imports import drives
from ppaas.imports.graphs.reading import import_graph
from ppaas.imports.maps.drawings.plan_import import import_plan
from ppaas.imports.maps.drawings.plan_picture import PlanOptions, ScaleBar
from ppaas.imports.maps.importing import import_map
from ppaas.imports.parameters.clone_check import refusal
from ppaas.imports.parameters.draft import Translation, robot_file
from ppaas.imports.parameters.nav2.importer import import_nav2
from ppaas.imports.parameters.ros1.importing import import_ros1
from ppaas.imports.parameters.slam.cartographer import import_cartographer
from ppaas.imports.parameters.slam.gmapping import import_gmapping
from ppaas.imports.parameters.slam.slam_toolbox import import_slam_toolbox
from ppaas.imports.report import ImportReport

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

CENTIMETRES = ScaleBar((0.0, 0.0), (100.0, 0.0), 1.0)
"""Scale of pictures of floor plans, which have none of their own: a unit is a centimetre."""


@dataclass(frozen=True, slots=True)
class ImportKind:
    """A kind of files.

    Parameters
    ----------
    name : str
    knows : callable
        Returns whether a file, by its name and content, is of this kind.
    run : callable
        Imports the content of a file of a name; returns what it became, and the report.
    bare : callable, optional
        Parses the content by the library of the format alone.
    drive : callable, optional
        Lets a robot drive by what it became; returns ``drove …`` or ``no: …``.
    """

    name: str
    knows: Callable[[str, bytes], bool]
    run: Callable[[bytes, str], tuple[Any, ImportReport]]
    bare: Callable[[bytes], object] | None = None
    drive: Callable[[Any], str] | None = None


# -- bare parses: what the library of a format alone takes -------------------------------------------------------------


def _yaml_tree(content: bytes) -> object:
    """Parse YAML by PyYAML, with libyaml where it is installed."""
    return yaml.load(content, Loader=_LOADER)


def _json_tree(content: bytes) -> object:
    """Parse JSON by msgspec."""
    return msgspec.json.decode(content)


def _las_points(content: bytes) -> object:
    """Read the points of LAS or LAZ by laspy."""
    import laspy  # noqa: PLC0415 - of the extra of clouds

    return laspy.read(io.BytesIO(content)).xyz


def _raster_bands(content: bytes) -> object:
    """Read the bands of a raster by rasterio."""
    import rasterio  # noqa: PLC0415 - of the extra of GIS

    with rasterio.MemoryFile(content) as memory, memory.open() as source:
        return source.read()


def _dxf_drawing(content: bytes) -> object:
    """Read a drawing in text by ezdxf."""
    from ezdxf.filemanagement import read  # noqa: PLC0415 - of the extra of drawings

    return read(io.StringIO(content.decode("utf-8", "surrogateescape")))


def _svg_picture(content: bytes) -> object:
    """Render an SVG in its own size by resvg."""
    import resvg_py  # noqa: PLC0415 - of the extra of drawings

    return resvg_py.svg_to_bytes(svg_string=content.decode(), skip_system_fonts=True)


# -- imports -----------------------------------------------------------------------------------------------------------


def _plan(content: bytes, name: str) -> tuple[Any, ImportReport]:
    """Import a floor plan; a drawing in DXF has units of its own."""
    is_drawing = name.lower().endswith(".dxf")
    imported, report, _ = import_plan(content, name, PlanOptions() if is_drawing else PlanOptions(CENTIMETRES))
    return imported, report


def _parameters(run: Callable[[bytes, str], Translation]) -> Callable[[bytes, str], tuple[Any, ImportReport]]:
    def imported(content: bytes, name: str) -> tuple[Any, ImportReport]:
        draft, report = run(content, name)
        own = {} if "map" in draft else {"map": "office"}
        return robot_file([(draft, report)], own, refusal), report

    return imported


def _file(pattern: str, words: bytes = b"") -> Callable[[str, bytes], bool]:
    name, inside = re.compile(pattern, re.IGNORECASE), re.compile(words)
    return lambda given, content: name.search(given) is not None and inside.search(content) is not None


_YAML, _JSON, _BINARY = r"\.ya?ml$", r"\.(geo)?json$", r"\.(pcd|ply|e57|xyz|asc)$"
_GRAPH = rb'"layouts"|"startid"|"FeatureCollection"'
_SLAM_TOOLBOX = rb"(?m)^/?(slam_toolbox|mapper_params)\S*:|use_scan_matching"
_NAV2_NODE = re.compile(rb"(?m)^\s*/?(amcl|bt_navigator|\w+_server|\w+_costmap|velocity_smoother)\S*:")


def _is_of_nav2(name: str, content: bytes) -> bool:
    """Return whether a file has nodes of Nav2, or nodes of ROS 2 that are not slam_toolbox alone."""
    if not _file(_YAML, rb"ros__parameters")(name, content):
        return False
    return _NAV2_NODE.search(content) is not None or not _file(_YAML, _SLAM_TOOLBOX)(name, content)


def _parameter_kind(name: str, words: bytes, run: Callable[[bytes, str], Translation]) -> ImportKind:
    return ImportKind(name, _file(_YAML, words), _parameters(run), _yaml_tree, drives.drive)


KINDS = (
    ImportKind("graph of Open-RMF", _file(_YAML, rb"(?m)^levels:"), import_graph, _yaml_tree, drives.drive_lanes),
    ImportKind("Nav2", _is_of_nav2, _parameters(import_nav2), _yaml_tree, drives.drive),
    _parameter_kind("slam_toolbox", _SLAM_TOOLBOX, import_slam_toolbox),
    _parameter_kind("gmapping", rb"(?m)^\s*(particles|linearUpdate|maxUrange):", import_gmapping),
    _parameter_kind("ROS 1 navigation", rb":", import_ros1),
    ImportKind("ROS 1 launch file", _file(r"\.launch$"), _parameters(import_ros1), None, drives.drive),
    ImportKind("cartographer", _file(r"\.lua$"), _parameters(import_cartographer), None, drives.drive),
    ImportKind("graph", _file(_JSON, _GRAPH), import_graph, _json_tree, drives.drive_lanes),
    ImportKind("Lanelet2", _file(r"\.osm$"), import_graph, None, drives.drive_lanes),
    ImportKind("map", _file(_JSON), import_map, _json_tree, drives.drive_on_imported),
    ImportKind("cloud", _file(r"\.la[sz]$"), import_map, _las_points, drives.drive_on_imported),
    ImportKind("raster", _file(r"\.tiff?$"), import_map, _raster_bands, drives.drive_on_imported),
    ImportKind("floor plan", _file(r"\.dxf$"), _plan, _dxf_drawing, drives.drive_on_imported),
    ImportKind("floor plan", _file(r"\.svg$"), _plan, _svg_picture, drives.drive_on_imported),
    ImportKind("cloud or raster", _file(_BINARY), import_map, None, drives.drive_on_imported),
)
"""All kinds; the first that knows a file imports it."""
