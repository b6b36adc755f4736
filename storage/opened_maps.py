"""Maps open for reading: their records and their files on this machine."""

from dataclasses import dataclass, field
from pathlib import Path

from ppaas.errors import InvalidMap, NotFound
from storage.records import MapRecord
from storage.staged_uploads import Buffer
from storage.versions import IMAGE, YAML


@dataclass(frozen=True, slots=True)
class OpenMap:
    """A version of a map with its files, valid inside the ``with`` block of ``MapStore.open_map``.

    Parameters
    ----------
    record : MapRecord
        The map, with this version.
    paths, buffers : dict
        Path of each file on this machine, and its content; the keys are from ``storage.versions.PARTS``.
    """

    record: MapRecord
    paths: dict[str, Path] = field(default_factory=dict)
    buffers: dict[str, Buffer] = field(default_factory=dict)

    def buffer(self, part: str) -> Buffer:
        """Return the content of a file; ``NotFound`` if the map has no such file."""
        if part not in self.buffers:
            raise NotFound(f"file of map {self.record.id!r}:", part, sorted(self.buffers))
        return self.buffers[part]

    def grid(self) -> tuple[bytes, Buffer]:
        """Return the YAML and the image of a map; ``InvalidMap`` if it has no grid."""
        if YAML not in self.buffers:
            raise no_grid(self.record)
        return bytes(self.buffers[YAML]), self.buffers[IMAGE]


def no_grid(record: MapRecord) -> InvalidMap:
    """Return the error for a map that has an octomap only."""
    return InvalidMap(f"map {record.id!r} has an octomap and no grid: publish a YAML with its image as well")
