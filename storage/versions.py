"""Versions of maps: named by what is in them, so that the same files are the same version everywhere; and heads."""

import hashlib
from collections.abc import Iterable

import msgspec

from ppaas.errors import Conflict, InvalidInput, NotFound
from storage.names import check_name
from storage.records import MapRecord, PlanRecord


def map_version(yaml: bytes, image: bytes) -> str:
    """Return the version of a map: SHA-256, in hex, of the length of the YAML, the YAML and the image."""
    digest = hashlib.sha256(len(yaml).to_bytes(8, "little"))
    digest.update(yaml)
    digest.update(image)
    return digest.hexdigest()


def new_map(
    map_id: str,
    owner: str,
    yaml: bytes,
    image: bytes,
    *,
    readers: Iterable[str] = (),
    created: float = 0.0,
    description: str = "",
) -> MapRecord:
    """Return the record of map files, named by their version; ``created`` is seconds since the epoch."""
    return MapRecord(map_id, owner, map_version(yaml, image), yaml, image, tuple(readers), created, description)


def without_files(record: MapRecord) -> MapRecord:
    """Return the head of a map."""
    return msgspec.structs.replace(record, yaml=b"", image=b"")


def without_poses(record: PlanRecord) -> PlanRecord:
    """Return the head of a plan."""
    return msgspec.structs.replace(record, poses=b"")


def changed_head(record: MapRecord, readers: tuple[str, ...] | None, description: str | None) -> MapRecord:
    """Return a map of which other things are said; None leaves what was."""
    return msgspec.structs.replace(
        record,
        readers=record.readers if readers is None else readers,
        description=record.description if description is None else description,
    )


def no_such_version(map_id: str, version: str) -> NotFound:
    """Return the error for a version that a map never had."""
    return NotFound(f"version of map {map_id!r}:", version)


def check_map(record: MapRecord) -> None:
    """Raise ``InvalidInput`` unless the names are names and the version is that of the files."""
    check_name("map", record.id)
    check_name("user", record.owner)
    expected = map_version(record.yaml, record.image)
    if record.version != expected:
        raise InvalidInput(f"map {record.id!r} is of version {expected}, not {record.version!r}")


def check_owner(before: MapRecord, record: MapRecord) -> None:
    """Raise ``Conflict`` where a map would change hands."""
    if before.owner != record.owner:
        raise Conflict(f"the map {record.id!r} belongs to another user: take another id")
