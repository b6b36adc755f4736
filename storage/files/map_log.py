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
from storage.names import check_name, is_name
from storage.opened_maps import OpenMap, open_verified
from storage.records import MapFile, MapRecord, MapVersionRecord, Publication
from storage.staged_uploads import MapDraft
from storage.versions import PARTS, check_files, check_may_follow, check_publication, no_such_version

_ATTEMPTS = 5
"""How often a map is looked up that is removed each time while it is read."""


class _Entry(msgspec.Struct, frozen=True):
    """What is said of a map; one that was removed has no present version."""

    era: int
    owner: str = ""
    readers: tuple[str, ...] = ()
    description: str = ""
    present: MapVersionRecord | None = None

    @classmethod
    def of(cls, record: MapRecord, era: int) -> "_Entry":
        """Return what is kept of a map."""
        return cls(era, record.owner, record.readers, record.description, record.present)


class _Latest(msgspec.Struct, frozen=True):
    """The last entry of a log, its number, and the map as it says."""

    number: int
    era: int
    record: MapRecord | None


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
                self._place(draft, _files(said.map, era))
                placed.add(era)
            record = _published(latest, said, draft)
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
            before = _known(said.map, latest)
            check_may_follow(before, said)
            found = self._find(before, latest.era, version)
            if found.version == before.version:
                return before
            record = _said(before, said, _present(latest, said, found.version, found.files, restored=True))
            if self._append(latest, record, latest.era):
                return record

    def map_head(self, map_id: str) -> MapRecord:
        """Return a map in its present version; ``NotFound`` if there is none."""
        check_name("map", map_id)
        return _known(map_id, self._latest(map_id))

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
        return list(islice(self._history(_known(map_id, latest), latest.era, before), limit))

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
            record = _changed(_known(map_id, latest), readers, description)
            if record == latest.record or self._append(latest, record, latest.era):
                return record

    def remove_map(self, map_id: str) -> None:
        """Forget a map and its versions; ``NotFound`` if there is none."""
        check_name("map", map_id)
        while True:
            latest = self._latest(map_id)
            _known(map_id, latest)
            number = latest.number + 1
            if self._disk.create(_entry(map_id, number), msgspec.json.encode(_Entry(number))):
                self._sweep(map_id, number)
                return

    # -- reading -------------------------------------------------------------------------------------------------------

    def _latest(self, map_id: str) -> _Latest:
        for _ in range(_ATTEMPTS):
            numbers = self._numbers(map_id)
            if not numbers:
                return _Latest(0, 0, None)
            try:
                entry = self._read(map_id, max(numbers))
            except FileNotFoundError:
                continue  # removed, and published anew, since the names were read
            record = _record(map_id, entry)
            return _Latest(max(numbers), entry.era, record)
        raise _restless(map_id)

    def _numbers(self, map_id: str) -> list[int]:
        return [int(name) for name in self._disk.names(f"{map_id}/log") if name.isdecimal()]

    def _read(self, map_id: str, number: int) -> _Entry:
        path = _entry(map_id, number)
        try:
            return msgspec.json.decode(self._disk.read(path), type=_Entry)
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
            record = _known(map_id, latest)
            if version not in (None, record.version):
                found = self._find(record, latest.era, version or "")
                record = msgspec.structs.replace(record, present=found)
            try:
                return open_verified(stack, self._disk, _files(map_id, latest.era), record, only)
            except FileNotFoundError as error:
                if self._latest(map_id).era == latest.era:
                    raise Unavailable(f"files of the map {map_id!r} are missing: publish it again") from error
        raise _restless(map_id)

    # -- writing -------------------------------------------------------------------------------------------------------

    def _place(self, draft: MapDraft, folder: str) -> None:
        for part, file in draft.files.items():
            self._disk.place(draft.path(part), f"{folder}/{file.sha256}")

    def _append(self, latest: _Latest, record: MapRecord, era: int) -> bool:
        data = msgspec.json.encode(_Entry.of(record, era))
        return self._disk.create(_entry(record.id, latest.number + 1), data)

    def _sweep(self, map_id: str, era: int) -> None:
        """Remove what is left of the map that had the id before: nobody looks behind the entry of this era."""
        if era == 1:
            return
        for number in sorted(self._numbers(map_id)):
            if number < era:
                self._disk.remove(_entry(map_id, number))
        for name in self._disk.names(map_id):
            start = name.removeprefix("files-")
            if start.isdecimal() and int(start) < era:
                self._disk.remove(f"{map_id}/{name}")


def _entry(map_id: str, number: int) -> str:
    return f"{map_id}/log/{number:08d}"


def _files(map_id: str, era: int) -> str:
    return f"{map_id}/files-{era}"


def _record(map_id: str, entry: _Entry) -> MapRecord | None:
    if entry.present is None:
        return None
    return MapRecord(map_id, entry.owner, entry.present, entry.readers, entry.description)


def _known(map_id: str, latest: _Latest) -> MapRecord:
    if latest.record is None:
        raise NotFound("map", map_id)
    return latest.record


def _published(latest: _Latest, said: Publication, draft: MapDraft) -> MapRecord:
    """Return a map with these files; where they are the present ones already, nothing is published."""
    before = latest.record
    if before is not None and before.version == draft.version:
        return _said(before, said, before.present)
    return _said(before, said, _present(latest, said, draft.version, dict(draft.files)))


def _present(
    latest: _Latest, said: Publication, version: str, files: dict[str, MapFile], *, restored: bool = False
) -> MapVersionRecord:
    return MapVersionRecord(latest.number + 1, version, said.created, said.author, said.message, restored, files)


def _said(before: MapRecord | None, said: Publication, present: MapVersionRecord) -> MapRecord:
    record = MapRecord(said.map, said.owner or said.author, present) if before is None else before
    return _changed(msgspec.structs.replace(record, present=present), said.readers, said.description)


def _changed(record: MapRecord, readers: tuple[str, ...] | None, description: str | None) -> MapRecord:
    """Return a map of which other things are said; None leaves what was."""
    return msgspec.structs.replace(
        record,
        readers=record.readers if readers is None else readers,
        description=record.description if description is None else description,
    )


def _restless(map_id: str) -> Unavailable:
    return Unavailable(f"the map {map_id!r} is removed and published again and again: try later")
