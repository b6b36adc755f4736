"""Notes on the kernel modules of one cache: which are compiled, and which somebody waits for.

All compilers of a cache share them, also in other clouds on this computer. So one that was killed is
continued, one that waits for another knows how far that is, and the one that compiles begins with what is waited for.
"""

import contextlib
import fcntl
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO

from engine.runtimes.compilation import stamp

_WANTED = ".wanted"


class ModuleNotes:
    """Notes in a folder beside a stamp file. Where it cannot be written, this process alone knows them.

    Parameters
    ----------
    stamp_file : Path
        Stamp file of all kernels of the cache (``stamp.stamp_file``).
    """

    def __init__(self, stamp_file: Path) -> None:
        self._folder = stamp_file.with_suffix("")
        self._lock_file = stamp_file.with_suffix(".lock")
        self._files: dict[str, list[str]] = {}
        self._wanted: set[str] = set()

    def compiled(self) -> dict[str, list[str]]:
        """Return the index files in the cache of each compiled module, by its name."""
        for note in self._folder.glob("*.json"):
            name = note.name.removesuffix(".json")
            if name not in self._files and (files := stamp.noted_files(note)) is not None:
                self._files[name] = files
        return self._files

    def note(self, module: str, files: Iterable[str]) -> None:
        """Note that a module is compiled into these files."""
        self._files[module] = sorted(files)
        self._wanted.discard(module)
        with contextlib.suppress(OSError):  # then this process alone knows it, and the next one loads the kernels again
            stamp.write_files(self._folder / f"{module}.json", self._files[module])
            (self._folder / f"{module}{_WANTED}").unlink(missing_ok=True)

    def want(self, modules: Iterable[str]) -> None:
        """Note that somebody waits for modules."""
        for module in set(modules) - self.compiled().keys():
            self._wanted.add(module)
            with contextlib.suppress(OSError):  # then the compiler of this process alone knows it
                self._folder.mkdir(parents=True, exist_ok=True)
                (self._folder / f"{module}{_WANTED}").touch()

    def wanted(self) -> set[str]:
        """Return the modules that somebody waits for."""
        marked = {mark.name.removesuffix(_WANTED) for mark in self._folder.glob(f"*{_WANTED}")}
        return (marked | self._wanted) - self.compiled().keys()

    @contextlib.contextmanager
    def turn(self) -> Iterator[bool]:
        """Enter with true if no other process compiles into this cache until the context ends, else with false.

        Where the file of the lock cannot be created, nothing is locked.
        """
        try:
            self._lock_file.parent.mkdir(parents=True, exist_ok=True)
            lock = self._lock_file.open("w")
        except OSError:
            yield True
            return
        with lock:
            yield _locked(lock)


def _locked(lock: IO[str]) -> bool:
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
