"""A map from the disk: the YAML of map_server and the image that it names."""

from pathlib import Path

from ppaas.errors import InvalidMap
from ppaas.maps.files import load_map
from ppaas.maps.grid import GridMap
from ppaas.maps.record import parse_yaml


def read_map_files(path: Path) -> tuple[bytes, bytes]:
    """Return the bytes of the YAML file and of its image, which is looked for beside it.

    Raises
    ------
    InvalidMap
        One of the two cannot be read, or the YAML is not a map's.
    """
    try:
        record = path.read_bytes()
        image = (path.parent / parse_yaml(record).image).read_bytes()
    except OSError as error:
        raise InvalidMap(f"cannot read the map: {error}") from error
    return record, image


def read_map_file(path: Path) -> GridMap:
    """Return the map of a YAML file.

    Raises
    ------
    InvalidMap
        It or its image cannot be read.
    """
    return load_map(*read_map_files(path))
