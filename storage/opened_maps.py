"""Maps that are being read: their files on this machine, proved to be those that were published."""

import hashlib
from collections.abc import Collection
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from ppaas.errors import InvalidMap, NotFound, Unavailable
from storage.files.disk import Disk
from storage.records import MapFile, MapRecord
from storage.staged_uploads import Buffer, mapped
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


def open_verified(stack: ExitStack, disk: Disk, folder: str, record: MapRecord, only: Collection[str]) -> OpenMap:
    """Return a map with files of a folder, open until the stack is unwound; ``Unavailable`` if they are damaged."""
    opened = OpenMap(record)
    for part, file in record.present.files.items():
        if part in only:
            path = opened.paths[part] = stack.enter_context(disk.opened(f"{folder}/{file.sha256}"))
            opened.buffers[part] = _verified(mapped(path), record, part, file)
    return opened


def _verified(data: Buffer, record: MapRecord, part: str, file: MapFile) -> Buffer:
    if len(data) != file.size or hashlib.sha256(data).hexdigest() != file.sha256:
        raise Unavailable(f"the {part} of the map {record.id!r} is not what was published: publish it again")
    return data
