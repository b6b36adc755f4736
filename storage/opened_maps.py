"""Maps that are open for reading: their records and their files on this machine."""

from dataclasses import dataclass, field
from pathlib import Path

from ppaas.errors import InvalidMap, NotFound
from storage.records import MapRecord
from storage.staged_uploads import Buffer
from storage.versions import IMAGE, YAML


@dataclass(frozen=True, slots=True)
class OpenMap:
    """A version of a map and its files, as long as the store is asked to hold them open.

    Parameters
    ----------
    record : MapRecord
        What is said of it.
    paths, buffers : dict
        Where each file is on this machine, and what is in it.
    """

    record: MapRecord
    paths: dict[str, Path] = field(default_factory=dict)
    buffers: dict[str, Buffer] = field(default_factory=dict)

    def buffer(self, part: str) -> Buffer:
        """Return what is in a file; ``NotFound`` if the map has no such file."""
        if part not in self.buffers:
            raise NotFound(f"file of map {self.record.id!r}:", part, sorted(self.buffers))
        return self.buffers[part]

    def grid(self) -> tuple[bytes, Buffer]:
        """Return the YAML and the image of a map; ``InvalidMap`` if it has none."""
        if YAML not in self.buffers:
            raise no_grid(self.record)
        return bytes(self.buffers[YAML]), self.buffers[IMAGE]


def no_grid(record: MapRecord) -> InvalidMap:
    """Return the error for a map that lies in space alone."""
    return InvalidMap(f"the map {record.id!r} has an octomap and no grid: publish a YAML with its image as well")
