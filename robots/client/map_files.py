"""A map on the disk: the YAML of map_server and the image that it names."""

from pathlib import Path

from ppaas.errors import InvalidMap
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.formats.map_yaml import parse_yaml
from ppaas.maps.grid import GridMap


def find_map_files(path: Path) -> tuple[bytes, Path]:
    """Return the bytes of the YAML file, and where its image is: it is looked for beside it.

    Raises
    ------
    InvalidMap
        One of the two is not there, or the YAML is not a map's.
    """
    try:
        record = path.read_bytes()
        image = path.parent / parse_yaml(record).image
        if not image.is_file():
            raise InvalidMap(f"cannot read the map: there is no file {str(image)!r}")
    except (OSError, ValueError) as error:
        raise InvalidMap(f"cannot read the map: {error}") from error
    return record, image


def read_map_files(path: Path) -> tuple[bytes, bytes]:
    """Return the bytes of the YAML file and of its image; raises as ``find_map_files`` does."""
    record, image = find_map_files(path)
    try:
        return record, image.read_bytes()
    except OSError as error:
        raise InvalidMap(f"cannot read the map: {error}") from error


def beside(folder: Path, map_id: str, yaml: bytes) -> tuple[Path, Path]:
    """Return where in a folder the YAML of a map goes, ``<map_id>.yaml``, and its image by the name that this gives it.

    Raises
    ------
    InvalidMap
        The YAML is not a map's, or names an image that is elsewhere.
    """
    record, name = folder / f"{map_id}.yaml", parse_yaml(yaml).image
    if name != Path(name).name or name in (".", "..", record.name):
        raise InvalidMap(f"the YAML names the image {name!r}, which would not be beside it: fetch both by REST")
    return record, folder / name


def read_map_file(path: Path) -> GridMap:
    """Return the map of a YAML file.

    Raises
    ------
    InvalidMap
        It or its image cannot be read.
    """
    return load_map(*read_map_files(path))
