"""Copies of maps in a folder: the files that a fetch may write, and their names.

A fetch never overwrites a file that no fetch made, or that was changed since. The name, map and hash of each fetched
file are noted in a file of the folder.
"""

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path, PurePath

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import Conflict, InvalidInput
from ppaas.maps.formats.image import ENDINGS, format_of
from ppaas.maps.formats.map_yaml import parse_yaml, with_image

NOTES = ".ppaas-fetched.json"
"""Name of the file with the notes."""

FULL_OCTREE = b"# Octomap OcTree file"
"""First line of a full octree (.ot); a binary one (.bt) has another."""

_MAGIC = 16
"""Bytes of an image that decide its format."""


class _Note(msgspec.Struct, frozen=True):
    """File that a fetch made: the map that it belongs to, and its SHA-256."""

    map: str
    sha256: str


class MapCopies:
    """Files of one map in a folder.

    Parameters
    ----------
    folder : Path
        The folder.
    map_id : str
        Id of the map.
    """

    def __init__(self, folder: Path, map_id: str) -> None:
        self._folder = folder
        self._map = map_id
        self._notes = _read_notes(folder)

    def keep(self, parts: Mapping[str, Path]) -> list[Path]:
        """Move downloaded files of the map into the folder, all or none; return their paths.

        Parameters
        ----------
        parts : mapping
            Downloaded files by part, on the same file system: ``yaml`` and ``image``, ``octomap``, ``posegraph``,
            ``zones``.

        Raises
        ------
        Conflict
            A file of the folder would be lost.
        InvalidMap
            The YAML does not describe a map, or the image has an unknown format.
        InvalidInput
            A file cannot be written.
        """
        try:
            names = {part: self._name(part, parts) for part in parts}
            if "image" in parts:
                _name_image(parts["yaml"], names["image"])
            for part, name in names.items():
                self._check(name, parts[part])
            return self._move(parts, names)
        except OSError as error:
            raise InvalidInput(f"cannot write map {self._map!r} to {self._folder}: {error}") from error

    def _name(self, part: str, parts: Mapping[str, Path]) -> str:
        if part == "yaml":
            return f"{self._map}.yaml"
        if part == "zones":
            return f"{self._map}.zones.geojson"
        if part == "posegraph":
            return f"{self._map}.posegraph"
        if part == "octomap":
            with parts[part].open("rb") as file:
                return f"{self._map}.ot" if file.readline().rstrip() == FULL_OCTREE else f"{self._map}.bt"
        return self._image_name(parts["yaml"].read_bytes(), parts[part])

    def _image_name(self, record: bytes, image: Path) -> str:
        """Return the image name of the YAML record; another one if that is taken, or not the name of an image."""
        given = PurePath(parse_yaml(record).image).name
        is_image = PurePath(given).suffix.lower() in ENDINGS and not given.startswith(".")
        if is_image and given.isprintable() and self._is_ours(given, image):
            return given
        with image.open("rb") as file:
            return self._map + format_of(file.read(_MAGIC)).endings[0]

    def _is_ours(self, name: str, new: Path) -> bool:
        """Return whether a file may take this name: it is free, or its file is equal or an unchanged copy."""
        path = self._folder / name
        if not os.path.lexists(path):
            return True
        if path.is_symlink() or not path.is_file():
            return False
        note, present = self._notes.get(name), _hash(path)
        return present == (_hash(new) if note is None else note.sha256 if note.map == self._map else None)

    def _check(self, name: str, new: Path) -> None:
        if not self._is_ours(name, new):
            raise Conflict(
                f"{self._folder / name} exists, and no fetch of map {self._map!r} made it as it is: move it away, or "
                "choose another folder with --to"
            )

    def _move(self, parts: Mapping[str, Path], names: Mapping[str, str]) -> list[Path]:
        self._notes |= {name: _Note(self._map, _hash(parts[part])) for part, name in names.items()}
        notes = parts[next(iter(parts))].with_name(NOTES)
        notes.write_bytes(msgspec.json.format(msgspec.json.encode(self._notes)))
        moved = [parts[part].replace(self._folder / name) for part, name in names.items()]
        notes.replace(self._folder / NOTES)
        return moved


def _name_image(yaml: Path, name: str) -> None:
    """Write a name of the image into a YAML file, unless it has that name already."""
    record = yaml.read_bytes()
    if PurePath(parse_yaml(record).image) != PurePath(name):
        yaml.write_bytes(with_image(record, name))


def _read_notes(folder: Path) -> dict[str, _Note]:
    try:
        return from_json((folder / NOTES).read_bytes(), dict[str, _Note])
    except (OSError, msgspec.DecodeError):
        return {}


def _hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
