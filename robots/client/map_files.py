"""Map files: the YAML file of map_server with the image that it names, or a map of the MovingAI benchmarks."""

import re
from pathlib import Path, PureWindowsPath

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.maps.formats.image import ENDINGS
from ppaas.maps.formats.map_files import load_map, save_map
from ppaas.maps.formats.map_yaml import Rules, parse_yaml
from ppaas.maps.formats.movingai import parse_map
from ppaas.maps.grid import GridMap

MOVINGAI = ".map"
"""Ending of the maps of the MovingAI benchmarks."""

_YAML_ENDINGS = (".yaml", ".yml", ".YAML", ".YML")
_NO_NAME = re.compile(r"[^A-Za-z0-9_.-]+")


def yaml_of(path: Path) -> Path:
    """Return the YAML file of a map, given that file or its image."""
    if path.suffix.lower() not in ENDINGS:
        return path
    found = (path.with_suffix(ending) for ending in _YAML_ENDINGS)
    return next((file for file in found if file.is_file()), path.with_suffix(_YAML_ENDINGS[0]))


def is_movingai(path: Path) -> bool:
    """Return whether a file is a map of the MovingAI benchmarks, by the ending of its name."""
    return path.suffix.lower() == MOVINGAI


def map_id_of(path: Path) -> str:
    """Return the id under which a map file is published: its name without the ending.

    Raises
    ------
    InvalidInput
        The name cannot be an id; the text suggests one.
    """
    name = path.stem
    suggested = _NO_NAME.sub("-", name).strip("-_.")[:64] or "map"
    if name != suggested:
        raise InvalidInput(
            f"the name of the file, {name!r}, cannot be the id of a map: choose one with --id NAME, as --id {suggested}"
        )
    return name


def find_map_files(path: Path) -> tuple[bytes, Path]:
    """Return the bytes of the YAML file of a map, and the path of the image that it names.

    Parameters
    ----------
    path : Path
        The YAML file, or an image beside a YAML file of the same name.

    Raises
    ------
    InvalidMap
        A file is missing, or the YAML does not describe a map.
    """
    file = yaml_of(path)
    if file != path and path.exists() and not file.exists():
        raise InvalidMap(f"{path.name!r} is an image: give the YAML file that names it; there is no {str(file)!r}")
    try:
        record = file.read_bytes()
        image = _image_of(file, parse_yaml(record).image)
    except (OSError, ValueError) as error:
        raise InvalidMap(f"cannot read the map: {error}") from error
    return record, image


def _image_of(file: Path, name: str) -> Path:
    """Return the image that a YAML file names: an absolute path, one of the user's home (``~``), or from its folder."""
    image = file.parent / (Path(name).expanduser() if name.startswith("~/") else name)
    if image.is_file():
        return image
    beside = file.parent / PureWindowsPath(name).name  # of paths with slashes, too
    advice = f"; {str(beside)!r} does: write `image: {beside.name}`" if beside.is_file() else ""
    raise InvalidMap(f"cannot read the map: image {str(image)!r} does not exist{advice}")


def read_map_files(path: Path) -> tuple[bytes, bytes]:
    """Return the bytes of the YAML file and of its image. Raises as ``find_map_files`` does."""
    record, image = find_map_files(path)
    try:
        return record, image.read_bytes()
    except OSError as error:
        raise InvalidMap(f"cannot read the map: {error}") from error


def files_to_publish(path: Path) -> tuple[bytes, bytes | Path]:
    """Return the bytes of the YAML file of a map and its image; a map of MovingAI is converted.

    Raises
    ------
    InvalidMap
        A file cannot be read, or does not describe a map.
    """
    if is_movingai(path):
        return save_map(read_map_file(path), f"{path.stem}.pgm")
    return find_map_files(path)


def read_map_file(path: Path, rules: Rules | None = None) -> GridMap:
    """Load the map of a YAML file, of the image beside it, or of MovingAI.

    Parameters
    ----------
    path : Path
        The file.
    rules : Rules, optional
        Replace the rules that a YAML file names.

    Raises
    ------
    InvalidMap
        The file or its image cannot be read.
    """
    if not is_movingai(path):
        return load_map(*read_map_files(path), rules)
    try:
        return parse_map(path.read_bytes())
    except OSError as error:
        raise InvalidMap(f"cannot read the map: {error}") from error
