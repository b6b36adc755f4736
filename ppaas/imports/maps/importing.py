"""Import of a map of any known format, which its first bytes and the ending of its name decide."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import PurePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.imports.collection import uncollected
from ppaas.imports.maps.clouds import cloud_map, las
from ppaas.imports.maps.clouds.octomap_file import MAGIC, read_octomap
from ppaas.imports.maps.clouds.pcd import read_pcd
from ppaas.imports.maps.clouds.ply import read_ply
from ppaas.imports.maps.clouds.point_cloud import PointCloud
from ppaas.imports.maps.clouds.xyz import read_xyz
from ppaas.imports.maps.common.imported_map import ImportedMap, MapOptions
from ppaas.imports.maps.gis.projection import local_frame, parse_projection
from ppaas.imports.maps.gis.raster import import_raster
from ppaas.imports.maps.household.json_content import decoded_json
from ppaas.imports.maps.household.openmower import import_openmower, is_openmower
from ppaas.imports.maps.household.valetudo import import_valetudo, is_valetudo
from ppaas.imports.maps.household.valetudo_re import import_valetudo_re, is_valetudo_re
from ppaas.imports.report import ImportReport
from ppaas.maps.georeference import GeoAnchor

Imported = tuple[ImportedMap, ImportReport]
_Reader = Callable[[bytes, ImportReport], PointCloud]

PICTURES = (".png", ".jpg", ".jpeg", ".bmp")

CLOUDS: dict[str, _Reader] = {
    ".pcd": read_pcd, ".ply": read_ply, ".las": las.read_las, ".laz": las.read_las,
    ".xyz": read_xyz, ".txt": read_xyz, ".csv": read_xyz, ".pts": read_xyz,
    ".bt": read_octomap, ".ot": read_octomap,
}  # fmt: skip
_MAGIC: tuple[tuple[bytes, _Reader], ...] = (
    (las.MAGIC, las.read_las), (b"ply\n", read_ply), (b"ply\r", read_ply),
    (b"# .PCD", read_pcd), *((magic, read_octomap) for magic in MAGIC),
)  # fmt: skip
_NEXT_STEPS = {
    ".yaml": "publish it with 'ppaas map publish'", ".yml": "publish it with 'ppaas map publish'",
    ".map": "publish it with 'ppaas map publish'", ".bag": "save the map of OpenMower as JSON in its web interface",
    ".svg": "import it with 'ppaas map from-plan'", ".dxf": "import it with 'ppaas map from-plan'",
    ".pdf": "import it with 'ppaas map from-plan'",
}  # fmt: skip


@uncollected()
def import_map(content: bytes, name: str, options: MapOptions | None = None) -> Imported:
    """Import a map.

    Parameters
    ----------
    content : bytes
    name : str
        Name of the file.
    options : MapOptions, optional

    Raises
    ------
    InvalidMap
        The format is unknown, or the file cannot be read at all; the text says why, and what to do.
    InvalidInput
        A library for the format is not installed, or an option does not suit the file.
    """
    options = options or MapOptions()
    ending = PurePath(name).suffix.lower()
    if not content:
        raise InvalidMap("the file is empty")
    if ending in _NEXT_STEPS:
        raise InvalidInput(f"{name} is not a file for this command: {_NEXT_STEPS[ending]}")
    if _is_raster(content, ending, options):
        return import_raster(content, name, options)
    reader = next((read for magic, read in _MAGIC if content.startswith(magic)), CLOUDS.get(ending))
    if ending == ".asc":
        reader = read_xyz
    if reader is not None:
        return import_cloud(content, name, options, reader)
    return _import_json(content, name, options)


def import_cloud(content: bytes, name: str, options: MapOptions, read: _Reader) -> Imported:
    """Import a point cloud.

    Parameters
    ----------
    content : bytes
    name : str
    options : MapOptions
    read : callable
        Reader of its format.

    Raises
    ------
    InvalidMap
        The file cannot be read, or the map would have no free cell, or too many cells.
    InvalidInput
        A library for the format is not installed, or an option does not suit the file.
    """
    report = ImportReport(name)
    cloud, anchor = _on_earth(_upright(read(content, report), options, report), report)
    imported = cloud_map.map_of_cloud(cloud, options, report)
    return imported.anchored(anchor).anchored(options.anchor), report


def _upright(cloud: PointCloud, options: MapOptions, report: ImportReport) -> PointCloud:
    """Return a cloud in metres with z up."""
    if options.up == "z" and options.unit == 1.0:
        return cloud
    if cloud.projection is not None or cloud.octree is not None:
        report.refused("--up, --unit", "the file has its own axes and metres")
        return cloud
    report.translated("axes", f"{options.up} of the file is up, and its unit {options.unit:g} m")

    def turned(places: NDArray[Any]) -> NDArray[Any]:
        x, y, z = (places[..., axis] for axis in range(3))
        axes = (x, -z, y) if options.up == "y" else (x, y, z)
        return np.asarray(np.stack(axes, axis=-1) * places.dtype.type(options.unit))

    origins = tuple(replace(each, place=tuple(turned(np.array(each.place)).tolist())) for each in cloud.origins)
    return replace(cloud, points=turned(cloud.points), offset=turned(cloud.offset), origins=origins)


def _on_earth(cloud: PointCloud, report: ImportReport) -> tuple[PointCloud, GeoAnchor | None]:
    """Return a cloud in metres to the east and north of its offset, with the georeference of that."""
    if cloud.projection is None:
        if cloud.offset.any():
            x, y, _ = cloud.offset.tolist()
            report.translated("origin", f"{x:.0f}, {y:.0f} of the file becomes 0, 0; it names no coordinate system")
        return cloud, None
    try:
        anchor, metres = local_frame(parse_projection(cloud.projection), *cloud.offset[:2].tolist())
    except (InvalidMap, InvalidInput) as error:
        report.refused("coordinate system", f"{error}; the map has no georeference")
        return cloud, None
    points = cloud.points.copy()
    points[:, :2] = cloud.points[:, :2] @ metres.T.astype(np.float32)
    report.translated("georeference", f"0, 0 of the map is {anchor.latitude:.7f}, {anchor.longitude:.7f}, x is east")
    return replace(cloud, points=points), anchor


def _is_raster(content: bytes, ending: str, options: MapOptions) -> bool:
    if content[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"):
        return True
    if ending in PICTURES:
        return options.world is not None or options.resolution is not None
    return content[:1024].lstrip()[:5].lower() == b"ncols"


def _import_json(content: bytes, name: str, options: MapOptions) -> Imported:
    try:
        tree: Any = decoded_json(content)
    except InvalidMap as error:
        raise InvalidMap(f"{name}: {error}; {_known()}") from error
    for is_one, import_one in (
        (is_valetudo, import_valetudo), (is_valetudo_re, import_valetudo_re), (is_openmower, import_openmower),
    ):  # fmt: skip
        if is_one(tree):
            return import_one(content, name, options, tree)
    raise InvalidMap(f"{name}: the JSON is neither a map of Valetudo nor one of OpenMower; {_known()}")


def _known() -> str:
    return f"known: maps of Valetudo and OpenMower, {', '.join(CLOUDS)}, GeoTIFF, .asc, and pictures with world files"
