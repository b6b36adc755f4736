"""Maps on a disk: files named by their hash, and for each map a log of its changes.

::

    house/
    ├── log/00000001, 00000002 …   metadata and version of the map; the last entry is current
    └── files-1/<sha256> …         files of all versions; 1 is the number of the map's first entry, its *era*

A writer places the files first and creates the log entry last. An entry is never overwritten: of concurrent writers,
one gets the next number, and the others read the map again and retry. So a reader sees a map before or after a change,
no change is lost, no lock is held, and a killed writer leaves at most files that no entry names. A removal is an entry
too. A later map of the same id continues the log with a new era and folder, so the old files can be deleted
at any time.

A version that waits for its review is part of the entries too, so that its approval is one entry; see
``storage.files.reviewed_maps``.

A removal of versions is an entry too, which lists the publications. Their files are deleted after it, and their entries
last, so that an interrupted removal is finished by the next one. A writer may just be publishing the same files again,
so a file is first moved aside. It is moved back if the log names it by then, and the writer looks for its files after
it has created its entry.
"""

import logging
from collections.abc import Collection, Iterator
from contextlib import ExitStack, contextmanager
from itertools import islice

import msgspec

from ppaas.errors import NotFound, Unavailable
from storage.files.disk import Disk, open_verified
from storage.files.log_entries import (
    LatestEntry,
    MapLogEntry,
    changed,
    decode_entry,
    encode_entry,
    entry_path,
    files_path,
    followed,
    published,
    rolled_back,
)
from storage.files.version_sweep import VersionSweep
from storage.map_port import OpenMap
from storage.names import check_name, is_name
from storage.records import MapRecord, MapReview, MapVersionRecord, Publication
from storage.staged_uploads import StagedUpload
from storage.versions import (
    PARTS,
    check_may_follow,
    check_publication,
    check_removable,
    no_such_version,
)

logger = logging.getLogger(__name__)

_ATTEMPTS = 5
"""Attempts to read a map that is removed while it is read."""


class LoggedMapStore:
    """A ``MapStore`` on a disk, which any number of threads, processes and machines may use at once.

    Parameters
    ----------
    disk : Disk
        Disk with the files.
    """

    def __init__(self, disk: Disk) -> None:
        self._disk = disk
        self._damaged: set[str] = set()

    @contextmanager
    def stage(self) -> Iterator[StagedUpload]:
        """Open an upload for the files of a version; unless published, they are removed at the end of the block."""
        with self._disk.staging_folder() as folder:
            yield StagedUpload(folder)

    def publish(self, upload: StagedUpload, publication: Publication) -> MapRecord:
        """Make the uploaded files the current version of a map, atomically; return the map's record."""
        check_publication(publication)
        placed = set()
        while True:
            latest = self._latest(publication.map)
            check_may_follow(latest.record, publication)
            record = published(latest, publication, upload)
            era = latest.era if latest.record is not None else latest.number + 1
            if era not in placed:
                self._place(upload, files_path(publication.map, era))
                placed.add(era)
            if record == latest.record:
                return record
            if self._append(latest, record, era, reviews=followed(latest, record)):
                self._replace_moved(upload, files_path(publication.map, era))
                self._sweep(publication.map, era)
                return record

    def roll_back(self, version: str, publication: Publication) -> MapRecord:
        """Make an earlier version of a map current again; return the map's record."""
        check_publication(publication)
        check_name("version", version)
        while True:
            latest = self._latest(publication.map)
            before = latest.head(publication.map)
            check_may_follow(before, publication)
            found = self._find(latest, before, version)
            if found.version == before.version:
                return before
            record = rolled_back(latest, publication, found)
            if self._append(latest, record, latest.era, reviews=followed(latest, record)):
                return record

    def map_head(self, map_id: str) -> MapRecord:
        """Return a map in its current version; ``NotFound`` if it does not exist."""
        check_name("map", map_id)
        return self._latest(map_id).head(map_id)

    def maps(self, visible_to: str | None = None, *, after: str = "", limit: int | None = None) -> list[MapRecord]:
        """Return the maps that a user may read, or all, sorted by id; damaged ones are left out and logged."""
        ids = sorted(name for name in self._disk.folders() if is_name(name) and name > after)
        heads = (self._readable_head(map_id) for map_id in ids)
        records = (record for record in heads if record is not None)
        seen = (record for record in records if visible_to is None or record.readable_by(visible_to))
        return list(islice(seen, limit))

    def map_ids(self) -> list[str]:
        """Return the ids of all maps, sorted, including damaged and removed ones."""
        return sorted(name for name in self._disk.folders() if is_name(name))

    def versions(self, map_id: str, *, before: int | None = None, limit: int | None = None) -> list[MapVersionRecord]:
        """Return the publications of a map, newest first; ``NotFound`` if the map does not exist."""
        check_name("map", map_id)
        latest = self._latest(map_id)
        return list(islice(self._history(latest, latest.head(map_id), before), limit))

    @contextmanager
    def open_map(self, map_id: str, version: str | None = None, *, only: Collection[str] = PARTS) -> Iterator[OpenMap]:
        """Open a version of a map for reading, by default the current one; ``NotFound`` if it does not exist."""
        check_name("map", map_id)
        if version is not None:
            check_name("version", version)
        with ExitStack() as stack:
            yield self._open(stack, map_id, version, only)

    def change_map(
        self,
        map_id: str,
        *,
        readers: tuple[str, ...] | None = None,
        description: str | None = None,
        traffic: bool | None = None,
    ) -> MapRecord:
        """Change the metadata of a map; return its head."""
        check_name("map", map_id)
        while True:
            latest = self._latest(map_id)
            record = changed(latest.head(map_id), readers, description, traffic)
            if record == latest.record or self._append(latest, record, latest.era):
                return record

    def remove_versions(self, map_id: str, versions: Collection[str]) -> None:
        """Remove versions of a map, with the files that no other version has."""
        check_name("map", map_id)
        for version in versions:
            check_name("version", version)
        while True:
            latest = self._latest(map_id)
            head = latest.head(map_id)
            listed = [one for one in self._history(latest, head) if one.version in versions]
            check_removable(head, versions, {one.version for one in listed})
            removed = latest.removed.union(one.number for one in listed)
            if not removed or self._append(latest, head, latest.era, removed):
                break
        self._sweep_of(map_id).run(self._latest(map_id))

    def remove_map(self, map_id: str) -> None:
        """Remove a map and its versions; ``NotFound`` if it does not exist."""
        check_name("map", map_id)
        while True:
            latest = self._latest(map_id)
            latest.head(map_id)
            number = latest.number + 1
            if self._disk.create(entry_path(map_id, number), encode_entry(MapLogEntry(number))):
                self._sweep(map_id, number)
                return

    # -- reading -------------------------------------------------------------------------------------------------------

    def _latest(self, map_id: str) -> LatestEntry:
        for _ in range(_ATTEMPTS):
            numbers = self._numbers(map_id)
            if not numbers:
                return LatestEntry(0, 0, None)
            try:
                entry = self._read(map_id, max(numbers))
            except FileNotFoundError:
                continue  # the map was removed and published again after the names were read
            unfinished = frozenset(entry.removed).intersection(numbers)
            return LatestEntry(max(numbers), entry.era, entry.record(map_id), unfinished, entry.reviews)
        raise _unstable(map_id)

    def _readable_head(self, map_id: str) -> MapRecord | None:
        """Return the head of a map; None if it was removed, or if its log is damaged, which must not hide others."""
        try:
            return self._latest(map_id).record
        except Unavailable as error:
            if not isinstance(error.__cause__, msgspec.MsgspecError | UnicodeDecodeError):
                raise
            if map_id not in self._damaged:
                self._damaged.add(map_id)
                logger.error("map %r is left out of lists: %s", map_id, error)
            return None

    def _numbers(self, map_id: str) -> list[int]:
        return [int(name) for name in self._disk.names(f"{map_id}/log") if name.isdecimal()]

    def _read(self, map_id: str, number: int) -> MapLogEntry:
        path = entry_path(map_id, number)
        return decode_entry(self._disk.read(path), f"{path} of the maps")

    def _history(self, latest: LatestEntry, head: MapRecord, before: int | None = None) -> Iterator[MapVersionRecord]:
        """Yield the publications, newest first. Each entry has the version that was current when it was written."""
        begin = latest.number if before is None else min(latest.number, before - 1)
        for number in sorted(self._numbers(head.id), reverse=True):
            if latest.era <= number <= begin:
                present = self._read_version(head.id, number, latest.era)
                if present is None:
                    continue
                begin = present.number - 1
                if present.number not in latest.removed:
                    yield present

    def _read_version(self, map_id: str, number: int, era: int) -> MapVersionRecord | None:
        """Return the version of an entry; None if the entry was removed after the names were read."""
        try:
            return self._read(map_id, number).present
        except FileNotFoundError:
            if self._latest(map_id).era == era:
                return None
            raise NotFound("map", map_id) from None  # the whole map was removed

    def _find(self, latest: LatestEntry, head: MapRecord, version: str) -> MapVersionRecord:
        """Return the publication of a version with its files, which a rollback does not repeat."""
        for one in self._history(latest, head):
            if one.version == version and not one.restored:
                return one
        raise no_such_version(head.id, version)

    def _find_any(self, latest: LatestEntry, head: MapRecord, version: str) -> MapVersionRecord:
        """Return a publication of a version, or the version as it waits for its review."""
        for one in latest.reviews:
            if one.waits and one.version == version:
                return MapVersionRecord(one.number, version, one.created, one.author, one.message, files=one.files)
        return self._find(latest, head, version)

    def _open(self, stack: ExitStack, map_id: str, version: str | None, only: Collection[str]) -> OpenMap:
        for _ in range(_ATTEMPTS):
            latest = self._latest(map_id)
            record = latest.head(map_id)
            if version not in (None, record.version):
                found = self._find_any(latest, record, version or "")
                record = msgspec.structs.replace(record, present=found)
            try:
                return open_verified(stack, self._disk, files_path(map_id, latest.era), record, only)
            except FileNotFoundError as error:
                if self._latest(map_id).number == latest.number:
                    raise Unavailable(f"files of map {map_id!r} are missing: publish it again") from error
        raise _unstable(map_id)

    # -- writing -------------------------------------------------------------------------------------------------------

    def _place(self, upload: StagedUpload, folder: str) -> None:
        for part, file in upload.files.items():
            self._disk.place(upload.path(part), f"{folder}/{file.sha256}")

    def _replace_moved(self, upload: StagedUpload, folder: str) -> None:
        """Place the files again that a removal of versions has moved aside before it could know of this publication."""
        names = self._disk.names(folder)
        for part, file in upload.files.items():
            if file.sha256 not in names:
                self._disk.place(upload.path(part), f"{folder}/{file.sha256}")

    def _append(
        self,
        latest: LatestEntry,
        record: MapRecord,
        era: int,
        removed: Collection[int] | None = None,
        reviews: tuple[MapReview, ...] | None = None,
    ) -> bool:
        """Create the next entry; return whether no other writer did. Without them, its lists are the last entry's."""
        entry = MapLogEntry.of(record, era)
        if era == latest.era:
            unfinished = latest.removed if removed is None else removed
            entry = MapLogEntry.of(record, era, sorted(unfinished), latest.reviews if reviews is None else reviews)
        return self._disk.create(entry_path(record.id, latest.number + 1), encode_entry(entry))

    def _sweep_of(self, map_id: str) -> VersionSweep:
        return VersionSweep(self._disk, map_id, read=self._read, newest=self._latest, history=self._history)

    def _sweep(self, map_id: str, era: int) -> None:
        """Remove entries and files of former maps of this id; no reader looks before the first entry of the era."""
        if era == 1:
            return
        for number in sorted(self._numbers(map_id)):
            if number < era:
                self._disk.remove(entry_path(map_id, number))
        for name in self._disk.names(map_id):
            start = name.removeprefix("files-")
            if start.isdecimal() and int(start) < era:
                self._disk.remove(f"{map_id}/{name}")


def _unstable(map_id: str) -> Unavailable:
    return Unavailable(f"map {map_id!r} is being removed and published repeatedly: try again later")
