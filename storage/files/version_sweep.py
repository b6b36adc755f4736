"""Deletes the files and log entries of removed versions (``storage.files.map_log``)."""

from collections.abc import Callable, Collection, Iterable, Iterator

from storage.files.disk import Disk
from storage.files.log_entries import LatestEntry, MapLogEntry, entry_path, files_path
from storage.records import MapRecord, MapReview, MapVersionRecord

History = Callable[[LatestEntry, MapRecord], Iterator[MapVersionRecord]]


class VersionSweep:
    """Finishes the removals that the last entry of a map's log lists. Any number of processes may do so at once.

    Parameters
    ----------
    disk : Disk
        Disk with the map.
    map_id : str
        The map.
    read : callable
        Reads an entry of a log; ``FileNotFoundError`` if it does not exist.
    newest : callable
        Reads the last entry of a log.
    history : callable
        Yields the publications that are not removed.
    """

    def __init__(
        self,
        disk: Disk,
        map_id: str,
        *,
        read: Callable[[str, int], MapLogEntry],
        newest: Callable[[str], LatestEntry],
        history: History,
    ) -> None:
        self._disk = disk
        self._map = map_id
        self._read = read
        self._newest = newest
        self._history = history

    def run(self, latest: LatestEntry) -> None:
        """Delete the files of the removed publications that no other has, then their entries."""
        if not latest.removed or latest.record is None:
            return
        entries = {number: entry for one in latest.removed for number, entry in self._entries_of(one)}
        self.delete(self._files(entry.present for entry in entries.values()), latest)
        for number in sorted(entries, reverse=True):
            self._disk.remove(entry_path(self._map, number))

    def delete(self, names: Collection[str], latest: LatestEntry) -> None:
        """Delete the given files that neither a publication nor a waiting review has."""
        folder = files_path(self._map, latest.era)
        unused = set(names) - self._used(latest)
        for name in unused:
            self._disk.move(f"{folder}/{name}", f"{folder}/.removed-{name}")
        used = self._used(self._newest(self._map))
        for name in unused:
            if name in used:  # published again meanwhile
                self._disk.move(f"{folder}/.removed-{name}", f"{folder}/{name}")
            else:
                self._disk.remove(f"{folder}/.removed-{name}")

    def _entries_of(self, publication: int) -> Iterator[tuple[int, MapLogEntry]]:
        """Yield the entry of a publication, and those that changed the metadata while it was current."""
        number = publication
        while True:
            try:
                entry = self._read(self._map, number)
            except FileNotFoundError:
                return
            if entry.present is None or entry.present.number != publication:
                return
            yield number, entry
            number += 1

    def _used(self, latest: LatestEntry) -> set[str]:
        if latest.record is None:
            return set()
        return self._files(self._history(latest, latest.record)) | self._files(latest.reviews)

    @staticmethod
    def _files(versions: Iterable[MapVersionRecord | MapReview | None]) -> set[str]:
        return {file.sha256 for version in versions if version is not None for file in version.files.values()}
