"""Writing of a backup: all records of the stores as blocks of a repository."""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from ppaas.clock import epoch
from ppaas.errors import Conflict, NotFound
from storage.backup.files import CHUNK, KIND, FileWriter
from storage.backup.manifest import (
    FORMAT,
    FORMAT_OF_RECORDS,
    BackupManifest,
    BackupStream,
    Block,
    CloneLog,
    StoredFile,
    StoredPart,
    Versions,
    new_id,
)
from storage.backup.repository import Repository
from storage.migration.copying import PAGE, Key, by_pages
from storage.migration.map_records import MAP_KINDS, MapHistory
from storage.migration.store_records import KINDS, LISTED, LOG_PAGE
from storage.ports import MapStore, Store
from storage.records import CloneCheckpoint, PlanRecord
from storage.staged_uploads import Buffer

BLOCK = 1 << 20
"""Bytes of records from which a block is written."""

LEASES = ("master",)
"""Leases whose epochs are part of a backup."""

ATTEMPTS = 3
"""Times that a map is read which changes meanwhile."""

PLANS, CLONES = "plans", "checkpoints"

PlanIndex = list[list[tuple[str, bytes]]]
"""Of each block of plans the ids, and the digests of the heads."""


@dataclass(slots=True)
class Sources:
    """Stores to back up; each may be left out.

    Parameters
    ----------
    store, map_store : optional
    schemes : dict of str to str
        Schemes of their URLs, by ``store`` and ``map_store``.
    at_once : bool
        Whether ``store`` does not change while it is read.
    folder : Path
        Data folder.
    files : tuple of str
        Files in it, by their names there.
    """

    store: Store | None = None
    map_store: MapStore | None = None
    schemes: dict[str, str] = field(default_factory=dict)
    at_once: bool = False
    folder: Path = field(default_factory=Path)
    files: tuple[str, ...] = ()


@dataclass(slots=True)
class WrittenBackup:
    """Progress with one kind: records so far, and how many of them an earlier backup has stored."""

    kind: str
    records: int = 0
    reused: int = 0


class BackupWriter:
    """Writes one backup.

    Parameters
    ----------
    repository : Repository
        Its lock is held.
    sources : Sources
    renew : callable
        Called between pages, to renew the lock.

    Attributes
    ----------
    manifest : BackupManifest
        The backup, once ``steps`` has ended.
    """

    manifest: BackupManifest

    def __init__(self, repository: Repository, sources: Sources, renew: Callable[[], None]) -> None:
        self._repository = repository
        self._sources = sources
        self._renew = renew
        self._streams: dict[str, BackupStream] = {}
        self._logs: list[CloneLog] = []
        self._versions: Versions = {}
        self._files: tuple[StoredFile, ...] = ()
        self._size = 0
        self._earlier = repository.manifest("latest") if repository.ids() else None

    def steps(self) -> Iterator[WrittenBackup]:
        """Write everything; yield the progress after each page, and set ``manifest``.

        Raises
        ------
        Unavailable, Damaged
            Errors of the stores and of the repository. Blocks that were written stay; the next backup uses them.
        Conflict
            A map is changed so often that no state of it can be read.
        """
        begun, backup_id, store = epoch(), new_id(), self._sources.store
        if store is not None:
            for kind in KINDS:
                pages = (list(kind.read(store, keys).items()) for keys in kind.pages(store))
                yield from self._plans(store) if kind.name == PLANS else self._records(kind.name, pages)
        if self._sources.map_store is not None:
            yield from self._maps(self._sources.map_store)
        yield from self._data_files()
        self._repository.settle()
        self.manifest = BackupManifest(
            backup_id, begun, epoch(), self._sources.schemes, self._sources.at_once, self._streams, tuple(self._logs),
            self._versions, self._epochs(), self._repository.added, self._size,
            FORMAT if self._files else FORMAT_OF_RECORDS, files=self._files,
        )  # fmt: skip
        self._repository.add(self.manifest)

    def _epochs(self) -> dict[str, int]:
        if self._sources.store is None:
            return {}
        leases = map(self._sources.store.lease, LEASES)
        return {lease.name: lease.epoch for lease in leases if lease.epoch}

    def _data_files(self) -> Iterator[WrittenBackup]:
        done, earlier = WrittenBackup(KIND), set() if self._earlier is None else set(self._earlier.files)
        writer = FileWriter(self._sources.folder, self._earlier, self._put)
        for name in self._sources.files:
            self._renew()
            file = writer.write(name)
            if file is not None:
                self._files = (*self._files, file)
                done.records += 1
                done.reused += file in earlier
            yield done

    # -- records ---------------------------------------------------------------------------------------------------

    def _records(self, kind: str, pages: Iterator[list[tuple[Key, Any]]]) -> Iterator[WrittenBackup]:
        done, blocks = WrittenBackup(kind), _Blocks(self._put)
        for page in pages:
            self._renew()
            for key, record in page:
                blocks.add((key, record))
                if kind == CLONES:
                    self._clone_logs(record)
            done.records += len(page)
            yield done
        self._streams[kind] = BackupStream(blocks.end())
        yield done

    def _clone_logs(self, clone: CloneCheckpoint) -> None:
        store = self._sources.store
        assert store is not None
        for log in store.clone_logs(clone.user, clone.robot):
            blocks, after = _Blocks(self._put), -1
            while entries := store.clone_log(clone.user, clone.robot, log, after=after, limit=LOG_PAGE):
                for entry in entries:
                    blocks.add(entry)
                after = entries[-1][0]
            self._logs.append(CloneLog(clone.user, clone.robot, log, blocks.end()))

    def _put(self, data: bytes | memoryview) -> str:
        self._size += len(data)
        return self._repository.put(data)

    # -- plans -----------------------------------------------------------------------------------------------------

    def _plans(self, store: Store) -> Iterator[WrittenBackup]:
        """Write the plans that the backup before does not have, and name its blocks of which all plans still exist."""
        done, earlier = WrittenBackup(PLANS), self._earlier_plans()
        place = {entry: block for block, entries in earlier.items() for entry in entries}
        left = {block: len(entries) for block, entries in earlier.items()}
        kept: dict[Block, list[str]] = {}
        blocks, index = _Blocks(self._put), []
        for heads in _plan_heads(store):
            self._renew()
            fresh = []
            for head in heads:
                block = place.get((head.id, _digest(head)))
                if block is None:
                    fresh.append(head.id)
                else:
                    left[block] -= 1
                    kept.setdefault(block, []).append(head.id)
            index += self._whole_plans(store, fresh, blocks)
            done.records += len(heads)
            done.reused += len(heads) - len(fresh)
            yield done
        for block, ids in kept.items():
            if left[block]:  # some of its plans are gone
                done.reused -= len(ids)
                index += self._whole_plans(store, ids, blocks)
        reused = {block: earlier[block] for block in kept if not left[block]}
        new = blocks.end()
        self._streams[PLANS] = BackupStream((*reused, *new), self._plan_index([*reused.values(), *_split(index, new)]))
        yield done

    def _whole_plans(self, store: Store, ids: Sequence[str], blocks: "_Blocks") -> list[tuple[str, bytes]]:
        found = []
        for first in range(0, len(ids), PAGE):
            for plan_id, plan in store.whole_plans(ids[first : first + PAGE]).items():
                blocks.add((plan_id, plan))
                found.append((plan_id, _digest(msgspec.structs.replace(plan, poses=b""))))
        return found

    def _earlier_plans(self) -> dict[Block, list[tuple[str, bytes]]]:
        stream = None if self._earlier is None else self._earlier.streams.get(PLANS)
        if stream is None or not stream.index:
            return {}
        index = msgspec.msgpack.decode(self._repository.block(stream.index))
        return {block: [tuple(entry) for entry in of] for block, of in zip(stream.blocks, index, strict=True)}

    def _plan_index(self, index: PlanIndex) -> str:
        return self._put(msgspec.msgpack.encode(index))

    # -- maps ------------------------------------------------------------------------------------------------------

    def _maps(self, store: MapStore) -> Iterator[WrittenBackup]:
        [kind] = MAP_KINDS
        done, blocks = WrittenBackup(kind.name), _Blocks(self._put)
        for keys in kind.pages(store):
            for key in keys:
                log = self._map(store, key)
                if log is not None:
                    blocks.add((key, log))
                    done.records += 1
            yield done
        self._streams[kind.name] = BackupStream(blocks.end())
        yield done

    def _map(self, store: MapStore, map_id: str) -> MapHistory | None:
        """Write the files of a map; return its log, or None if it was removed meanwhile."""
        [kind] = MAP_KINDS
        for _ in range(ATTEMPTS):
            found = kind.read(store, [map_id])
            if not found:
                return None
            log: MapHistory = found[map_id]
            with suppress(NotFound):  # a version was removed meanwhile
                for version in log.versions():
                    self._version(store, map_id, version)
                return log
        raise Conflict(f"map {map_id!r} changed {ATTEMPTS} times while it was read: try again")

    def _version(self, store: MapStore, map_id: str, version: str) -> None:
        if version in self._versions:
            return
        if self._earlier is not None and version in self._earlier.versions:
            self._versions[version] = self._earlier.versions[version]
            return
        with store.open_map(map_id, version) as opened:
            files = opened.record.present.files
            self._versions[version] = {
                part: StoredPart(files[part].sha256, files[part].size, tuple(self._chunks(buffer)))
                for part, buffer in opened.buffers.items()
            }

    def _chunks(self, buffer: Buffer) -> Iterator[str]:
        with memoryview(buffer) as view:
            for first in range(0, len(view), CHUNK):
                self._renew()
                yield self._put(view[first : first + CHUNK])


class _Blocks:
    """Collects records, and writes them as blocks."""

    def __init__(self, put: Callable[[bytes], str]) -> None:
        self._put = put
        self._records: list[bytes] = []
        self._bytes = 0
        self._done: list[Block] = []

    def add(self, record: Any) -> None:
        """Add a record: any value that MessagePack can encode."""
        data = msgspec.msgpack.encode(record)
        self._records.append(data)
        self._bytes += len(data)
        if self._bytes >= BLOCK:
            self._write()

    def end(self) -> tuple[Block, ...]:
        """Write the rest; return all blocks."""
        if self._records:
            self._write()
        return tuple(self._done)

    def _write(self) -> None:
        # An array of MessagePack: its header, then the records as they are.
        header = b"\xdd" + len(self._records).to_bytes(4)
        self._done.append(Block(self._put(header + b"".join(self._records)), len(self._records)))
        self._records, self._bytes = [], 0


def _plan_heads(store: Store) -> Iterator[list[PlanRecord]]:
    def of(map_id: str) -> Iterator[list[PlanRecord]]:
        return by_pages(
            lambda before: store.plans(map_id, before=before, limit=LISTED), None, lambda plan: (plan.created, plan.id)
        )

    return (page for map_id in store.plan_maps() for page in of(map_id))


def _digest(head: PlanRecord) -> bytes:
    return hashlib.sha256(msgspec.msgpack.encode(head)).digest()[:8]


def _split(index: list[tuple[str, bytes]], blocks: Sequence[Block]) -> PlanIndex:
    """Return the entries of each of the blocks, which have the records in this order."""
    found, first = [], 0
    for block in blocks:
        found.append(index[first : first + block.records])
        first += block.records
    return found
