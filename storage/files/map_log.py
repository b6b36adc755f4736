"""Maps on a disk: files that are named by what is in them, and for each map a log of what became of it.

::

    house/
    ├── log/00000001, 00000002 …   what was said of the map; the last entry is the present
    └── files-1/<sha256> …         all files of all its versions; 1 is the entry with which the map began

Files come first and the entry last, which nobody can take the place of: of those who write at once, one has the next
number, and the others look at the map anew. So a reader sees a map as it was or as it is, no change is lost, nobody
holds a lock, and whoever is killed leaves files at most that no entry names. To remove a map is an entry too: who
publishes under its id later goes on behind it, with another folder of files, so that the old one can go at any time.
"""

from collections.abc import Collection, Iterator
from contextlib import ExitStack, contextmanager
from itertools import islice

import msgspec

from ppaas.errors import NotFound, Unavailable
from storage.files.disk import Disk
from storage.files.log_entries import LatestEntry, LogEntry, changed, entry_path, files_path, published, rolled_back
from storage.files.verified import open_verified
from storage.names import check_name, is_name
from storage.opened_maps import OpenMap
from storage.records import MapRecord, MapVersionRecord, Publication
from storage.staged_uploads import MapDraft
from storage.versions import PARTS, check_files, check_may_follow, check_publication, no_such_version

_ATTEMPTS = 5
"""How often a map is looked up that is removed each time while it is read."""


class LoggedMapStore:
    """A ``MapStore`` on a disk, which any number of threads, processes and machines may use.

    Parameters
    ----------
    disk : Disk
        What keeps the files.
    """

    def __init__(self, disk: Disk) -> None:
        self._disk = disk

    @contextmanager
    def drafting(self) -> Iterator[MapDraft]:
        """Write the files of a version, which are gone at the end of the block unless they were published in it."""
        with self._disk.drafting() as folder:
            yield MapDraft(folder)

    def publish(self, draft: MapDraft, said: Publication) -> MapRecord:
        """Make files the present version of a map, at once and whole; return its head."""
        check_publication(said)
        check_files(draft.files)
        placed = set()
        while True:
            latest = self._latest(said.map)
            check_may_follow(latest.record, said)
            era = latest.era if latest.record is not None else latest.number + 1
            if era not in placed:
                self._place(draft, files_path(said.map, era))
                placed.add(era)
            record = published(latest, said, draft)
            if record == latest.record:
                return record
            if self._append(latest, record, era):
                self._sweep(said.map, era)
                return record

    def roll_back(self, version: str, said: Publication) -> MapRecord:
        """Make a version that a map had the present one again; return its head."""
        check_publication(said)
        check_name("version", version)
        while True:
            latest = self._latest(said.map)
            before = latest.head(said.map)
            check_may_follow(before, said)
            found = self._find(before, latest.era, version)
            if found.version == before.version:
                return before
            record = rolled_back(latest, said, found)
            if self._append(latest, record, latest.era):
                return record

    def map_head(self, map_id: str) -> MapRecord:
        """Return a map in its present version; ``NotFound`` if there is none."""
        check_name("map", map_id)
        return self._latest(map_id).head(map_id)

    def maps(self, visible_to: str | None = None, *, after: str = "", limit: int | None = None) -> list[MapRecord]:
        """Return the maps that a user may read, or all, by id."""
        ids = sorted(name for name in self._disk.folders() if is_name(name) and name > after)
        heads = (self._latest(map_id).record for map_id in ids)
        records = (record for record in heads if record is not None)
        seen = (record for record in records if visible_to is None or record.readable_by(visible_to))
        return list(islice(seen, limit))

    def versions(self, map_id: str, *, before: int | None = None, limit: int | None = None) -> list[MapVersionRecord]:
        """Return what was published under an id, newest first; ``NotFound`` if there is no such map."""
        check_name("map", map_id)
        latest = self._latest(map_id)
        return list(islice(self._history(latest.head(map_id), latest.era, before), limit))

    @contextmanager
    def open_map(self, map_id: str, version: str | None = None, *, only: Collection[str] = PARTS) -> Iterator[OpenMap]:
        """Read the files of a version, the present one unless told; ``NotFound`` if there is none."""
        check_name("map", map_id)
        if version is not None:
            check_name("version", version)
        with ExitStack() as stack:
            yield self._open(stack, map_id, version, only)

    def change_map(
        self, map_id: str, *, readers: tuple[str, ...] | None = None, description: str | None = None
    ) -> MapRecord:
        """Change what is said of a map; return its head."""
        check_name("map", map_id)
        while True:
            latest = self._latest(map_id)
            record = changed(latest.head(map_id), readers, description)
            if record == latest.record or self._append(latest, record, latest.era):
                return record

    def remove_map(self, map_id: str) -> None:
        """Forget a map and its versions; ``NotFound`` if there is none."""
        check_name("map", map_id)
        while True:
            latest = self._latest(map_id)
            latest.head(map_id)
            number = latest.number + 1
            if self._disk.create(entry_path(map_id, number), msgspec.json.encode(LogEntry(number))):
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
                continue  # removed, and published anew, since the names were read
            return LatestEntry(max(numbers), entry.era, entry.record(map_id))
        raise _restless(map_id)

    def _numbers(self, map_id: str) -> list[int]:
        return [int(name) for name in self._disk.names(f"{map_id}/log") if name.isdecimal()]

    def _read(self, map_id: str, number: int) -> LogEntry:
        path = entry_path(map_id, number)
        try:
            return msgspec.json.decode(self._disk.read(path), type=LogEntry)
        except msgspec.MsgspecError as error:
            raise Unavailable(f"{path} of the maps is damaged ({error}): restore it from a backup") from error

    def _history(self, head: MapRecord, era: int, before: int | None = None) -> Iterator[MapVersionRecord]:
        """Yield what was published, newest first: each entry says which was the present one by then."""
        number = head.present.number if before is None else min(head.present.number, before - 1)
        while number >= era:
            present = self._read_version(head.id, number)
            yield present
            number = present.number - 1

    def _read_version(self, map_id: str, number: int) -> MapVersionRecord:
        try:
            present = self._read(map_id, number).present
        except FileNotFoundError:
            present = None
        if present is None:  # it was removed since the last entry was read
            raise NotFound("map", map_id)
        return present

    def _find(self, head: MapRecord, era: int, version: str) -> MapVersionRecord:
        """Return when a version was published with its files, not restored."""
        for one in self._history(head, era):
            if one.version == version and not one.restored:
                return one
        raise no_such_version(head.id, version)

    def _open(self, stack: ExitStack, map_id: str, version: str | None, only: Collection[str]) -> OpenMap:
        for _ in range(_ATTEMPTS):
            latest = self._latest(map_id)
            record = latest.head(map_id)
            if version not in (None, record.version):
                found = self._find(record, latest.era, version or "")
                record = msgspec.structs.replace(record, present=found)
            try:
                return open_verified(stack, self._disk, files_path(map_id, latest.era), record, only)
            except FileNotFoundError as error:
                if self._latest(map_id).era == latest.era:
                    raise Unavailable(f"files of the map {map_id!r} are missing: publish it again") from error
        raise _restless(map_id)

    # -- writing -------------------------------------------------------------------------------------------------------

    def _place(self, draft: MapDraft, folder: str) -> None:
        for part, file in draft.files.items():
            self._disk.place(draft.path(part), f"{folder}/{file.sha256}")

    def _append(self, latest: LatestEntry, record: MapRecord, era: int) -> bool:
        data = msgspec.json.encode(LogEntry.of(record, era))
        return self._disk.create(entry_path(record.id, latest.number + 1), data)

    def _sweep(self, map_id: str, era: int) -> None:
        """Remove what is left of the map that had the id before: nobody looks behind the entry of this era."""
        if era == 1:
            return
        for number in sorted(self._numbers(map_id)):
            if number < era:
                self._disk.remove(entry_path(map_id, number))
        for name in self._disk.names(map_id):
            start = name.removeprefix("files-")
            if start.isdecimal() and int(start) < era:
                self._disk.remove(f"{map_id}/{name}")


def _restless(map_id: str) -> Unavailable:
    return Unavailable(f"the map {map_id!r} is removed and published again and again: try later")
