"""Maps in memory, for tests and experiments: they are lost when the process ends."""

import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from storage.files.reviewed_maps import ReviewedMapStore
from storage.store_errors import disk_errors
from storage.temporary import temporary_folder


class MemoryMapStore(ReviewedMapStore):
    """A ``MapStore`` in memory."""

    def __init__(self) -> None:
        super().__init__(MemoryDisk())


class MemoryDisk:
    """A ``Disk`` that is a dictionary of paths."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._files: dict[str, bytes] = {}

    def folders(self) -> list[str]:
        """Return the names of the top-level folders."""
        return self.names("")

    def names(self, folder: str) -> list[str]:
        """Return the names in a folder; an empty list if it does not exist."""
        start = f"{folder}/" if folder else ""
        with self._lock:
            return list({path[len(start) :].partition("/")[0] for path in self._files if path.startswith(start)})

    def read(self, path: str) -> bytes:
        """Return the content of a file; ``FileNotFoundError`` if it does not exist."""
        with self._lock:
            if path not in self._files:
                raise FileNotFoundError(path)
            return self._files[path]

    def create(self, path: str, data: bytes) -> bool:
        """Create a file; return whether it is new."""
        with self._lock:
            return self._files.setdefault(path, data) is data

    def place(self, source: Path, path: str) -> None:
        """Store a copy of a local file."""
        with disk_errors(source):
            data = source.read_bytes()
        with self._lock:
            self._files[path] = data

    def move(self, source: str, target: str) -> bool:
        """Rename a file; return False if it does not exist."""
        with self._lock:
            if source not in self._files:
                return False
            self._files[target] = self._files.pop(source)
        return True

    @contextmanager
    def opened(self, path: str) -> Iterator[Path]:
        """Write a file to the local disk for the time of the block; ``FileNotFoundError`` if it does not exist."""
        data = self.read(path)
        with self.staging_folder() as folder:
            with disk_errors(folder):
                (folder / "file").write_bytes(data)
            yield folder / "file"

    def remove(self, path: str) -> None:
        """Remove a file, or a folder with its content, if it exists."""
        with self._lock:
            kept = self._files.items()
            self._files = {name: data for name, data in kept if name != path and not name.startswith(f"{path}/")}

    def staging_folder(self) -> AbstractContextManager[Path]:
        """Create a folder for temporary files."""
        return temporary_folder()
