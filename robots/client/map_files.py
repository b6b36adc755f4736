"""Map files: the YAML file of map_server and the image that it names."""

from pathlib import Path

from ppaas.errors import InvalidMap
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.formats.map_yaml import parse_yaml
from ppaas.maps.grid import GridMap


def find_map_files(path: Path) -> tuple[bytes, Path]:
    """Return the bytes of the YAML file and the path of its image, in the same folder.

    Raises
    ------
    InvalidMap
        A file is missing, or the YAML does not describe a map.
    """
    try:
        record = path.read_bytes()
        image = path.parent / parse_yaml(record).image
        if not image.is_file():
            raise InvalidMap(f"cannot read the map: image {str(image)!r} does not exist")
    except (OSError, ValueError) as error:
        raise InvalidMap(f"cannot read the map: {error}") from error
    return record, image


def read_map_files(path: Path) -> tuple[bytes, bytes]:
    """Return the bytes of the YAML file and of its image. Raises as ``find_map_files`` does."""
    record, image = find_map_files(path)
    try:
        return record, image.read_bytes()
    except OSError as error:
        raise InvalidMap(f"cannot read the map: {error}") from error


def beside(folder: Path, map_id: str, yaml: bytes) -> tuple[Path, Path]:
    """Return the paths for a map in a folder: ``<map_id>.yaml``, and the image under the name that the YAML gives it.

    Raises
    ------
    InvalidMap
        The YAML does not describe a map, or names an image in another folder.
    """
    record, name = folder / f"{map_id}.yaml", parse_yaml(yaml).image
    if name != Path(name).name or name in (".", "..", record.name):
        raise InvalidMap(
            f"the YAML names the image {name!r}, which is not in the same folder; download both files by REST"
        )
    return record, folder / name


def read_map_file(path: Path) -> GridMap:
    """Load the map of a YAML file.

    Raises
    ------
    InvalidMap
        The file or its image cannot be read.
    """
    return load_map(*read_map_files(path))
