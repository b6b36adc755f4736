"""Maps in memory, for tests and for trying things out: gone with the process."""

import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from storage.disk_errors import disk_errors
from storage.files.map_log import LoggedMapStore
from storage.staged_uploads import temporary_folder


class MemoryMapStore(LoggedMapStore):
    """A ``MapStore`` in memory."""

    def __init__(self) -> None:
        super().__init__(MemoryDisk())


class MemoryDisk:
    """A ``Disk`` that is a dictionary of paths."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._files: dict[str, bytes] = {}

    def folders(self) -> list[str]:
        """Return the names of the folders at the top."""
        return self.names("")

    def names(self, folder: str) -> list[str]:
        """Return what is in a folder; nothing if there is none."""
        start = f"{folder}/" if folder else ""
        with self._lock:
            return list({path[len(start) :].partition("/")[0] for path in self._files if path.startswith(start)})

    def read(self, path: str) -> bytes:
        """Return a file; ``FileNotFoundError`` if there is none."""
        with self._lock:
            if path not in self._files:
                raise FileNotFoundError(path)
            return self._files[path]

    def create(self, path: str, data: bytes) -> bool:
        """Keep a file; tell whether it is new."""
        with self._lock:
            return self._files.setdefault(path, data) is data

    def place(self, source: Path, path: str) -> None:
        """Keep a copy of a local file."""
        with disk_errors(source):
            data = source.read_bytes()
        with self._lock:
            self._files[path] = data

    @contextmanager
    def opened(self, path: str) -> Iterator[Path]:
        """Write a file to this machine's disk for a while; ``FileNotFoundError`` if there is none."""
        data = self.read(path)
        with self.drafting() as folder:
            with disk_errors(folder):
                (folder / "file").write_bytes(data)
            yield folder / "file"

    def remove(self, path: str) -> None:
        """Forget a file, or a folder with all that is in it, if there is one."""
        with self._lock:
            kept = self._files.items()
            self._files = {name: data for name, data in kept if name != path and not name.startswith(f"{path}/")}

    def drafting(self) -> AbstractContextManager[Path]:
        """Make a folder for temporary files."""
        return temporary_folder()
