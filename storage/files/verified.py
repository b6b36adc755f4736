"""Opens the files of a map after their hashes have been verified."""

import hashlib
from collections.abc import Collection
from contextlib import ExitStack

from ppaas.errors import Unavailable
from storage.files.disk import Disk
from storage.opened_maps import OpenMap
from storage.records import MapFile, MapRecord
from storage.staged_uploads import Buffer, mapped


def open_verified(stack: ExitStack, disk: Disk, folder: str, record: MapRecord, only: Collection[str]) -> OpenMap:
    """Return a map with its files, open until the stack is closed; ``Unavailable`` if a file is damaged."""
    opened = OpenMap(record)
    for part, file in record.present.files.items():
        if part in only:
            path = opened.paths[part] = stack.enter_context(disk.opened(f"{folder}/{file.sha256}"))
            opened.buffers[part] = _verified(mapped(path), record, part, file)
    return opened


def _verified(data: Buffer, record: MapRecord, part: str, file: MapFile) -> Buffer:
    if len(data) != file.size or hashlib.sha256(data).hexdigest() != file.sha256:
        raise Unavailable(f"the {part} of map {record.id!r} is damaged (its hash differs): publish it again")
    return data
