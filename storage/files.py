"""Maps in a folder, published so that nobody ever sees half of one.

::

    maps/
    ├── house/                    one folder a map
    │   ├── head.json             owner, readers, and which version is the present one
    │   └── versions/<sha256>/    map.yaml, image and version.json, never changed once they are there
    ├── .incoming/                what is being written
    ├── .removed/                 what is being removed
    └── .lock                     held by the one writer

A version is written aside, synced and renamed to its place; then the head is, in the same way. A writer killed
anywhere leaves the map as it was before or as it is after, and rubbish in the two dotted folders, which the next
writer sweeps away: the lock dies with its holder.
"""

import fcntl
import itertools
import os
import shutil
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec

from ppaas.errors import NotFound, Unavailable
from storage.failures import disk_errors
from storage.names import check_name, is_name
from storage.records import MapRecord, MapVersionRecord
from storage.versions import changed_head, check_map, check_owner, map_version, no_such_version

_HEAD = "head.json"
_VERSION = "version.json"
_VERSIONS = "versions"
_INCOMING = ".incoming"
_REMOVED = ".removed"
_ATTEMPTS = 3


class _Head(msgspec.Struct, frozen=True):
    """What ``head.json`` says."""

    owner: str
    version: str
    readers: tuple[str, ...]
    created: float
    description: str = ""

    @classmethod
    def of(cls, record: MapRecord) -> "_Head":
        """Return what is kept of a record beside its files."""
        return cls(record.owner, record.version, record.readers, record.created, record.description)

    def record(self, map_id: str, yaml: bytes = b"", image: bytes = b"") -> MapRecord:
        """Return the record of the map, with the files or without."""
        said = self.readers, self.created, self.description
        return MapRecord(map_id, self.owner, self.version, yaml, image, *said)


class _Version(msgspec.Struct, frozen=True):
    """What ``version.json`` says: when the version was published first."""

    created: float


class FileMapStore:
    """A ``MapStore`` in a folder, which any number of threads and processes may use.

    Parameters
    ----------
    root : Path
        The folder; it is made if it is not there.

    Raises
    ------
    Unavailable
        The folder cannot be used; the text says why and what to do.
    """

    def __init__(self, root: Path) -> None:
        self._root = root
        with disk_errors(root):
            for folder in (root, root / _INCOMING, root / _REMOVED):
                folder.mkdir(parents=True, exist_ok=True)
            (root / ".lock").touch()

    def put_map(self, record: MapRecord) -> None:
        """Publish a map or its new version, at once and whole; ``Conflict`` if it is another owner's."""
        check_map(record)
        folder = self._root / record.id
        head = _Head.of(record)
        with self._writing():
            before = self._head(record.id)
            if before is not None:
                check_owner(before.record(record.id), record)
            (folder / _VERSIONS).mkdir(parents=True, exist_ok=True)
            self._place_version(folder / _VERSIONS / record.version, record)
            self._place_head(folder / _HEAD, head)
            _sync_folder(self._root)

    def map(self, map_id: str, version: str | None = None) -> MapRecord:
        """Return the present version or another; ``NotFound`` if there is no such map or version."""
        check_name("map", map_id)
        if version is not None:
            check_name("version", version)
        with disk_errors(self._root / map_id):
            for _ in range(_ATTEMPTS):
                head = self._known_head(map_id)
                if version is not None:
                    head = self._head_of(map_id, head, version)
                try:
                    yaml, image = _read_files(self._root / map_id / _VERSIONS / head.version)
                except FileNotFoundError:
                    continue  # removed, and perhaps published anew, since the head was read
                if map_version(yaml, image) != head.version:
                    raise _damaged(map_id, "files are not those that were published")
                return head.record(map_id, yaml, image)
        raise _damaged(map_id, "files are missing")

    def map_head(self, map_id: str) -> MapRecord:
        """Return the present version without its files; ``NotFound`` if there is no such map."""
        check_name("map", map_id)
        with disk_errors(self._root / map_id):
            return self._known_head(map_id).record(map_id)

    def maps(self, visible_to: str | None = None, *, after: str = "", limit: int | None = None) -> list[MapRecord]:
        """Return the heads of the maps that a user may read, or of all, by id."""
        with disk_errors(self._root):
            ids = sorted(entry.name for entry in os.scandir(self._root) if is_name(entry.name) and entry.name > after)
            heads = ((map_id, self._head(map_id)) for map_id in ids)
            records = (head.record(map_id) for map_id, head in heads if head is not None)
            seen = (record for record in records if visible_to is None or record.readable_by(visible_to))
            return list(itertools.islice(seen, limit))

    def versions(
        self, map_id: str, *, before: MapVersionRecord | None = None, limit: int | None = None
    ) -> list[MapVersionRecord]:
        """Return the versions that a map ever had, newest first; ``NotFound`` if there is no such map."""
        check_name("map", map_id)
        folder = self._root / map_id / _VERSIONS
        with disk_errors(folder):
            self._known_head(map_id)
            names = [entry.name for entry in os.scandir(folder) if is_name(entry.name)]
            found = (MapVersionRecord(_read_version(folder / name).created, name) for name in names)
            return sorted((one for one in found if before is None or one < before), reverse=True)[:limit]

    def change_map(
        self, map_id: str, *, readers: tuple[str, ...] | None = None, description: str | None = None
    ) -> MapRecord:
        """Change what is said of a map; return its head."""
        check_name("map", map_id)
        with self._writing():
            changed = changed_head(self._known_head(map_id).record(map_id), readers, description)
            self._place_head(self._root / map_id / _HEAD, _Head.of(changed))
        return changed

    def remove_map(self, map_id: str) -> None:
        """Forget a map and its versions; ``NotFound`` if there is none."""
        check_name("map", map_id)
        with self._writing():
            self._known_head(map_id)
            (self._root / map_id).rename(self._aside(_REMOVED))
            _sync_folder(self._root)

    # -- reading -------------------------------------------------------------------------------------------------------

    def _known_head(self, map_id: str) -> _Head:
        head = self._head(map_id)
        if head is None:
            raise NotFound("map", map_id)
        return head

    def _head(self, map_id: str) -> _Head | None:
        try:
            head = msgspec.json.decode((self._root / map_id / _HEAD).read_bytes(), type=_Head)
        except (FileNotFoundError, NotADirectoryError):
            return None
        except msgspec.MsgspecError as error:
            raise self._damaged_head(map_id, str(error)) from error
        if not is_name(head.version):
            raise self._damaged_head(map_id, "it names no version")
        return head

    def _head_of(self, map_id: str, head: _Head, version: str) -> _Head:
        """Return the head of another version than the present one."""
        place = self._root / map_id / _VERSIONS / version
        if not place.is_dir():
            raise no_such_version(map_id, version)
        return msgspec.structs.replace(head, version=version, created=_read_version(place).created)

    def _damaged_head(self, map_id: str, why: str) -> Unavailable:
        path = self._root / map_id / _HEAD
        return Unavailable(f"{path}: damaged ({why}): restore it from a backup, or remove the folder")

    # -- writing -------------------------------------------------------------------------------------------------------

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Be the only writer of all processes; sweep away what others left behind before and what this one did."""
        with disk_errors(self._root), (self._root / ".lock").open("rb") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self._sweep()
            try:
                yield
            finally:
                self._sweep()

    def _sweep(self) -> None:
        for name in (_INCOMING, _REMOVED):
            for left in (self._root / name).iterdir():
                shutil.rmtree(left)

    def _aside(self, folder: str) -> Path:
        return self._root / folder / uuid.uuid4().hex

    def _place_version(self, place: Path, record: MapRecord) -> None:
        if place.exists():
            if _is_whole(place):
                return
            place.rename(self._aside(_REMOVED))
        aside = self._aside(_INCOMING)
        aside.mkdir()
        _write_synced(aside / "map.yaml", record.yaml)
        _write_synced(aside / "image", record.image)
        _write_synced(aside / _VERSION, msgspec.json.encode(_Version(record.created)))
        _sync_folder(aside)
        aside.rename(place)
        _sync_folder(place.parent)

    def _place_head(self, place: Path, head: _Head) -> None:
        aside = self._aside(_INCOMING)
        aside.mkdir()
        _write_synced(aside / place.name, msgspec.json.encode(head))
        (aside / place.name).replace(place)
        _sync_folder(place.parent)


def _read_files(version: Path) -> tuple[bytes, bytes]:
    return (version / "map.yaml").read_bytes(), (version / "image").read_bytes()


def _read_version(version: Path) -> _Version:
    try:
        return msgspec.json.decode((version / _VERSION).read_bytes(), type=_Version)
    except FileNotFoundError:  # on its way in or out, or kept before this was
        return _Version(0.0)
    except msgspec.MsgspecError as error:
        raise Unavailable(f"{version / _VERSION}: damaged ({error}): remove the file") from error


def _is_whole(version: Path) -> bool:
    """Tell whether the files of a version are still those that were published."""
    try:
        return map_version(*_read_files(version)) == version.name
    except FileNotFoundError:
        return False


def _write_synced(path: Path, data: bytes) -> None:
    with path.open("xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def _sync_folder(path: Path) -> None:
    """Make renames into a folder last: they are the folder's data."""
    handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _damaged(map_id: str, what: str) -> Unavailable:
    return Unavailable(f"the map {map_id!r} is damaged, its {what}: publish it again")
