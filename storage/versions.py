"""Versions of maps: named by what is in them, so that the same files are the same version everywhere."""

import hashlib
from collections.abc import Mapping

import msgspec

from ppaas.errors import Conflict, InvalidInput, NotFound
from storage.names import check_name
from storage.records import MapFile, MapRecord, PlanRecord, Publication

YAML, IMAGE, OCTOMAP = "yaml", "image", "octomap"
PARTS = (YAML, IMAGE, OCTOMAP)
"""The files that a map may have: a grid is the first two, and what lies in space the third."""


def map_version(files: Mapping[str, MapFile]) -> str:
    """Return the version of a map: SHA-256, in hex, of a line for each file, by name: its name and its SHA-256."""
    lines = (f"{name} {files[name].sha256}\n" for name in sorted(files))
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def without_poses(record: PlanRecord) -> PlanRecord:
    """Return the head of a plan."""
    return msgspec.structs.replace(record, poses=b"")


def no_such_version(map_id: str, version: str) -> NotFound:
    """Return the error for a version that a map never had."""
    return NotFound(f"version of map {map_id!r}:", version)


def check_publication(said: Publication) -> None:
    """Raise ``InvalidInput`` unless the names are names."""
    check_name("map", said.map)
    check_name("user", said.author)
    check_name("user", said.owner or said.author)
    if said.if_match is not None:
        check_name("version", said.if_match)


def check_files(files: Mapping[str, MapFile]) -> None:
    """Raise ``InvalidInput`` unless these are the files of a map."""
    if not files or set(files) - set(PARTS) or (YAML in files) != (IMAGE in files):
        given = ", ".join(sorted(files)) or "nothing"
        raise InvalidInput(f"a map has a yaml with its image, an octomap, or both; not {given}")


def check_may_follow(before: MapRecord | None, said: Publication) -> None:
    """Raise ``Conflict`` where a map would change hands, or another was faster."""
    if before is not None and before.owner != (said.owner or said.author):
        raise Conflict(f"the map {said.map!r} belongs to another user: take another id")
    if said.if_match is None or (before is not None and before.version == said.if_match):
        return
    present = "gone" if before is None else f"of version {before.version}"
    raise Conflict(f"the map {said.map!r} is {present}, not of version {said.if_match}: look at it again first")
