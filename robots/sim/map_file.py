"""A map on the disk: the YAML of map_server and the image that it names."""

from pathlib import Path

from ppaas.errors import InvalidInput, InvalidMap
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
    except (OSError, ValueError) as error:
        raise InvalidMap(f"cannot read the map: {error}") from error
    return record, image


def write_map_files(folder: Path, map_id: str, yaml: bytes, image: bytes) -> tuple[Path, Path]:
    """Write ``<map_id>.yaml``, and beside it the image under the name that the YAML gives it; return their paths.

    Raises
    ------
    InvalidMap
        The YAML is not a map's, or names an image that is elsewhere.
    InvalidInput
        They cannot be written.
    """
    record, name = folder / f"{map_id}.yaml", parse_yaml(yaml).image
    if name != Path(name).name or name in (".", "..", record.name):
        raise InvalidMap(f"the YAML names the image {name!r}, which would not be beside it: fetch both by REST")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        record.write_bytes(yaml)
        (folder / name).write_bytes(image)
    except (OSError, ValueError) as error:
        raise InvalidInput(f"cannot write the map: {error}") from error
    return record, folder / name


def read_map_file(path: Path) -> GridMap:
    """Return the map of a YAML file.

    Raises
    ------
    InvalidMap
        It or its image cannot be read.
    """
    return load_map(*read_map_files(path))
