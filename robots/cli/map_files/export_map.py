"""Verb ``ppaas map export``: writes a map in a format of other programs."""

import argparse
from pathlib import Path
from typing import Any

from ppaas.errors import InvalidInput
from robots.cli.output import print_line
from robots.cli.output_files import check_folder, write_file
from robots.cli.session import add_session_arguments, logged_in
from robots.cli.verbs.map_versions import whole_version
from robots.client.cloud_url import path_of

_YAML = (".yaml", ".yml")
_OCTOMAPS = (".bt", ".ot")
_CLOUDS, _RASTERS = (".pcd", ".ply", ".xyz"), (".tif", ".tiff")


def configure(verbs: Any) -> None:
    """Add the parser of the verb."""
    export = verbs.add_parser(
        "export",
        help="write a map as point cloud (.pcd, .ply, .xyz) or GeoTIFF (.tif)",
        description=(
            "A point cloud has the obstacles of the octomap, or of the grid at the height 0 if the map has none. A "
            "GeoTIFF has the grid, with the georeference of the map. 'ppaas map fetch' downloads the map as it is."
        ),
    )
    export.add_argument("map", help="id of a map of the cloud, YAML file, or octomap (.bt, .ot)")
    export.add_argument("--out", type=Path, required=True, metavar="FILE", help="file; its ending is the format")
    export.add_argument("--version", help="a version of the map, or a prefix of it (the current one)")
    add_session_arguments(export)


async def export(arguments: argparse.Namespace) -> None:
    """Write a map to a file."""
    ending = arguments.out.suffix.lower()
    if ending not in (*_CLOUDS, *_RASTERS):
        raise InvalidInput(f"unknown format {ending!r}; known: {', '.join((*_CLOUDS, *_RASTERS))}")
    check_folder(arguments.out)
    files = await _files(arguments)
    write_file(arguments.out, _raster(files) if ending in _RASTERS else _cloud(files, ending))
    print_line(str(arguments.out))


_Files = dict[str, bytes]
"""Files of a map: ``yaml``, ``image`` and ``octomap``, as far as it has them."""


async def _files(arguments: argparse.Namespace) -> _Files:
    source = Path(arguments.map)
    if source.suffix.lower() in (*_YAML, *_OCTOMAPS):
        return _local_files(source)
    client = logged_in(arguments)
    version = await whole_version(client, arguments.map, arguments.version)
    path = ("maps", arguments.map, *(() if version is None else ("versions", version)))
    parts = (await client.get(path_of(*path)))["parts"]
    return {part: await client.fetch(path_of(*path, part)) for part in ("yaml", "image", "octomap") if part in parts}


def _local_files(source: Path) -> _Files:
    from robots.client.map_files import read_map_files  # noqa: PLC0415 - reading YAML needs more than the base install

    try:
        if source.suffix.lower() in _OCTOMAPS:
            return {"octomap": source.read_bytes()}
        yaml, image = read_map_files(source)
        octomap = source.with_suffix(".bt")
        return {"yaml": yaml, "image": image, **({"octomap": octomap.read_bytes()} if octomap.is_file() else {})}
    except OSError as error:
        raise InvalidInput(f"cannot read the map: {error}") from error


def _raster(files: _Files) -> bytes:
    from ppaas.maps.exports.geotiff import geotiff_file  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from ppaas.maps.formats.map_files import load_map  # noqa: PLC0415
    from ppaas.maps.georeference import anchor_of  # noqa: PLC0415

    if "yaml" not in files:
        raise InvalidInput("the map has no grid, only an octomap: export it as a point cloud")
    return geotiff_file(load_map(files["yaml"], files["image"]), anchor_of(files["yaml"]))


def _cloud(files: _Files, ending: str) -> bytes:
    from ppaas.maps.exports import point_files  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from ppaas.maps.formats.map_files import load_map  # noqa: PLC0415
    from ppaas.maps.octomap import parse_octomap  # noqa: PLC0415

    if "octomap" in files:
        points = point_files.points_of_octree(parse_octomap(files["octomap"]))
    else:
        points = point_files.points_of_grid(load_map(files["yaml"], files["image"]))
    write = {".pcd": point_files.pcd_file, ".ply": point_files.ply_file, ".xyz": point_files.xyz_file}
    return write[ending](points)
