"""Versions of maps, named by the hash of their content: the same files have the same version everywhere."""

import hashlib
from collections.abc import Collection, Mapping

import msgspec

from ppaas.errors import Conflict, InvalidInput, NotFound
from storage.names import check_name
from storage.records import MapFile, MapRecord, PlanRecord, Publication

YAML, IMAGE, OCTOMAP, POSEGRAPH, ZONES = "yaml", "image", "octomap", "posegraph", "zones"
PARTS = (YAML, IMAGE, OCTOMAP, POSEGRAPH, ZONES)
"""The files of a map: an occupancy grid in two files, a map in space, the key frames that the grid was made of, and the
zones on the grid."""

ONLY_ZONES = frozenset({ZONES})
ALL_BUT_ZONES = frozenset(PARTS) - ONLY_ZONES


def map_version(files: Mapping[str, MapFile]) -> str:
    """Return the version of a map: the SHA-256, in hex, over the lines "name SHA-256" of its files, sorted by name."""
    lines = (f"{name} {files[name].sha256}\n" for name in sorted(files))
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def without_poses(record: PlanRecord) -> PlanRecord:
    """Return the head of a plan: its record without poses."""
    return msgspec.structs.replace(record, poses=b"")


def no_such_version(map_id: str, version: str) -> NotFound:
    """Return the error for a version that was never published for a map."""
    return NotFound(f"version of map {map_id!r}:", version)


def check_removable(head: MapRecord, versions: Collection[str], known: Collection[str]) -> None:
    """Raise ``NotFound`` if one of the versions to remove is not known, ``Conflict`` if it is the current one."""
    for version in versions:
        if version == head.version:
            raise Conflict(
                f"version {version} is the current one of map {head.id!r}: publish or roll back to another first"
            )
        if version not in known:
            raise no_such_version(head.id, version)


def check_publication(publication: Publication) -> None:
    """Raise ``InvalidInput`` if a name in a publication is not valid."""
    check_name("map", publication.map)
    check_name("user", publication.author)
    check_name("user", publication.owner or publication.author)
    if publication.if_match is not None:
        check_name("version", publication.if_match)


def check_files(files: Mapping[str, MapFile]) -> None:
    """Raise ``InvalidInput`` unless the files are a YAML with its image, or an octomap; others need the first two."""
    lacks_grid = YAML not in files and not files.keys().isdisjoint((POSEGRAPH, ZONES))
    if not files or set(files) - set(PARTS) or (YAML in files) != (IMAGE in files) or lacks_grid:
        given = ", ".join(sorted(files)) or "no file"
        raise InvalidInput(
            "a map needs a yaml with its image, an octomap, or all three; a posegraph or zones need a yaml with its "
            f"image; got {given}"
        )


def files_after(
    files: Mapping[str, MapFile], keeps: Collection[str], current: Mapping[str, MapFile]
) -> dict[str, MapFile]:
    """Return the files of a new version of a map.

    Parameters
    ----------
    files : mapping
        New files.
    keeps : collection of str
        Parts that it has from the current version, unless they are among the new files. Zones are not kept where there
        is no grid.
    current : mapping
        Files of the current version.
    """
    found = {part: file for part, file in current.items() if part in keeps} | dict(files)
    if YAML not in found and ZONES not in files:
        found.pop(ZONES, None)
    return found


def but_zones(files: Mapping[str, MapFile]) -> dict[str, MapFile]:
    """Return the files of a map other than its zones."""
    return {part: file for part, file in files.items() if part != ZONES}


def check_may_follow(before: MapRecord | None, publication: Publication) -> None:
    """Raise ``Conflict`` if the map belongs to another user, or if its current version is not ``if_match``."""
    if before is not None and before.owner != (publication.owner or publication.author):
        raise Conflict(f"map {publication.map!r} belongs to another user: choose another id")
    if publication.if_match is None or (before is not None and before.version == publication.if_match):
        return
    current = "does not exist" if before is None else f"is at version {before.version}"
    raise Conflict(f"map {publication.map!r} {current}, not at version {publication.if_match}: read it again and retry")
