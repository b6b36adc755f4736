"""Maps in a local folder, in the layout of ``storage.files.map_log``.

The folder also contains ``.incoming``, where files are written before they get their names, and ``.lock``, which is
held while ``.incoming`` is swept. Each writer locks its folder in ``.incoming``. The lock ends with the process, so the
next writer removes what a killed one left.
"""

import fcntl
import os
import shutil
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from storage.files.reviewed_maps import ReviewedMapStore
from storage.store_errors import disk_errors
from storage.temporary import locked, remove_unless_locked

_INCOMING, LOCK = ".incoming", ".lock"


class FileMapStore(ReviewedMapStore):
    """A ``MapStore`` in a folder.

    Parameters
    ----------
    root : Path
        The folder; it is created if it is missing.

    Raises
    ------
    Unavailable
        The folder cannot be used; the message says why and what to do.
    """

    def __init__(self, root: Path) -> None:
        super().__init__(LocalDisk(root))


def is_store(folder: Path) -> bool:
    """Return whether a folder is one of a `FileMapStore`; a copy of its maps alone is one, too."""
    return any((folder / name).exists() for name in (LOCK, _INCOMING)) or any(folder.glob("*/log"))


class LocalDisk:
    """A ``Disk`` in a folder of this machine, or in a network folder that several machines share."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._incoming = root / _INCOMING
        with disk_errors(root):
            self._incoming.mkdir(parents=True, exist_ok=True)
            (root / LOCK).touch()

    def folders(self) -> list[str]:
        """Return the names of the top-level folders."""
        with disk_errors(self._root), os.scandir(self._root) as entries:
            return [entry.name for entry in entries if entry.is_dir()]

    def names(self, folder: str) -> list[str]:
        """Return the names in a folder; an empty list if it does not exist."""
        with disk_errors(self._root / folder):
            try:
                return [entry.name for entry in (self._root / folder).iterdir()]
            except (FileNotFoundError, NotADirectoryError):
                return []

    def read(self, path: str) -> bytes:
        """Return the content of a small file; ``FileNotFoundError`` if it does not exist."""
        with disk_errors(self._root / path, but=FileNotFoundError):
            return (self._root / path).read_bytes()

    def create(self, path: str, data: bytes) -> bool:
        """Create a small file and sync it; return whether it is new."""
        place = self._root / path
        with disk_errors(place), self.staging_folder() as aside:
            _make_folder(place.parent)
            _write_synced(aside / "file", data)
            try:
                place.hardlink_to(aside / "file")  # unlike a rename, it never replaces an existing file
            except FileExistsError:
                return False
            _sync_folder(place.parent)
        return True

    def place(self, source: Path, path: str) -> None:
        """Store a hard link to a local file. It replaces an existing file, which may be damaged."""
        place = self._root / path
        with disk_errors(place), self.staging_folder() as aside:
            _make_folder(place.parent)
            (aside / "file").hardlink_to(source)
            (aside / "file").replace(place)
            _sync_folder(place.parent)

    def move(self, source: str, target: str) -> bool:
        """Rename a file; return False if it does not exist."""
        with disk_errors(self._root / source):
            try:
                (self._root / source).replace(self._root / target)
            except FileNotFoundError:
                return False
        return True

    @contextmanager
    def opened(self, path: str) -> Iterator[Path]:
        """Yield the path of a file; ``FileNotFoundError`` if it does not exist."""
        with disk_errors(self._root / path, but=FileNotFoundError):
            (self._root / path).stat()
        yield self._root / path

    def remove(self, path: str) -> None:
        """Remove a file, or a folder with its content, if it exists."""
        place = self._root / path
        with disk_errors(place), suppress(FileNotFoundError):
            if place.is_dir():
                shutil.rmtree(place)
            else:
                place.unlink()

    @contextmanager
    def staging_folder(self) -> Iterator[Path]:
        """Create a folder in ``.incoming``, and remove the folders of killed writers."""
        folder = self._incoming / uuid.uuid4().hex
        with disk_errors(self._root):
            held = self._take(folder)
        try:
            yield folder
        finally:
            with disk_errors(folder):
                shutil.rmtree(folder, ignore_errors=True)
                os.close(held)

    def _take(self, folder: Path) -> int:
        with (self._root / LOCK).open("rb") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            for left in self._incoming.iterdir():
                remove_unless_locked(left)
            folder.mkdir()
            return locked(folder)


def _make_folder(folder: Path) -> None:
    if folder.is_dir():
        return
    _make_folder(folder.parent)
    folder.mkdir(exist_ok=True)
    _sync_folder(folder.parent)


def _write_synced(path: Path, data: bytes) -> None:
    with path.open("xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def _sync_folder(path: Path) -> None:
    """Sync a folder, that is the names of its files."""
    handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
