"""Entries of the log of a map: where they are, what is in them, and which record follows from which."""

import msgspec

from ppaas.errors import NotFound
from storage.records import MapFile, MapRecord, MapVersionRecord, Publication
from storage.staged_uploads import MapDraft


class LogEntry(msgspec.Struct, frozen=True):
    """What is said of a map; one that was removed has no present version."""

    era: int
    owner: str = ""
    readers: tuple[str, ...] = ()
    description: str = ""
    present: MapVersionRecord | None = None

    @classmethod
    def of(cls, record: MapRecord, era: int) -> "LogEntry":
        """Return the entry that keeps a record."""
        return cls(era, record.owner, record.readers, record.description, record.present)

    def record(self, map_id: str) -> MapRecord | None:
        """Return the record that is kept; none if the map was removed."""
        if self.present is None:
            return None
        return MapRecord(map_id, self.owner, self.present, self.readers, self.description)


class LatestEntry(msgspec.Struct, frozen=True):
    """The last entry of a log, its number, and the map as it says."""

    number: int
    era: int
    record: MapRecord | None

    def head(self, map_id: str) -> MapRecord:
        """Return the map; ``NotFound`` if there is none."""
        if self.record is None:
            raise NotFound("map", map_id)
        return self.record


def entry_path(map_id: str, number: int) -> str:
    """Return the path of an entry on the disk."""
    return f"{map_id}/log/{number:08d}"


def files_path(map_id: str, era: int) -> str:
    """Return the path of the folder that has all files of all versions of a map."""
    return f"{map_id}/files-{era}"


def published(latest: LatestEntry, said: Publication, draft: MapDraft) -> MapRecord:
    """Return a map with these files; where they are the present ones already, nothing is published."""
    before = latest.record
    if before is not None and before.version == draft.version:
        return _with_present(before, said, before.present)
    return _with_present(before, said, _version(latest, said, draft.version, dict(draft.files)))


def rolled_back(latest: LatestEntry, said: Publication, found: MapVersionRecord) -> MapRecord:
    """Return a map whose present version is one that it had before."""
    present = _version(latest, said, found.version, found.files, restored=True)
    return _with_present(latest.record, said, present)


def changed(record: MapRecord, readers: tuple[str, ...] | None, description: str | None) -> MapRecord:
    """Return a map of which other things are said; None leaves what was."""
    return msgspec.structs.replace(
        record,
        readers=record.readers if readers is None else readers,
        description=record.description if description is None else description,
    )


def _version(
    latest: LatestEntry, said: Publication, version: str, files: dict[str, MapFile], *, restored: bool = False
) -> MapVersionRecord:
    return MapVersionRecord(latest.number + 1, version, said.created, said.author, said.message, restored, files)


def _with_present(before: MapRecord | None, said: Publication, present: MapVersionRecord) -> MapRecord:
    record = MapRecord(said.map, said.owner or said.author, present) if before is None else before
    return changed(msgspec.structs.replace(record, present=present), said.readers, said.description)
