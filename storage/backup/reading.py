"""Reading of a backup, as a store from which records are copied."""

import hashlib
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec

from ppaas.decoding import from_msgpack
from ppaas.errors import Damaged, NotFound
from ppaas.plans.history import LinkHistory, PlannerHistory
from storage.backup.manifest import BackupManifest, Block, StoredPart
from storage.backup.repository import Repository
from storage.buildings.records import BuildingRecord
from storage.map_port import OpenMap
from storage.migration.copying import Key, StoredKind
from storage.migration.map_records import MapHistory
from storage.people import MapPeople, PeopleCount
from storage.ports import Store
from storage.records import (
    CloneCheckpoint,
    Lease,
    MapRecord,
    MapTask,
    MapVersionRecord,
    PlanRecord,
    RobotRecord,
    Token,
    User,
)
from storage.staged_uploads import Buffer, mapped
from storage.store_errors import damaged
from storage.temporary import temporary_folder
from storage.versions import PARTS
from storage.webhooks.records import Webhook, WebhookDelivery

RECORDS: dict[str, Any] = {
    "users": User,
    "tokens": Token,
    "robots": RobotRecord,
    "URDFs": tuple[str, str, bytes],
    "checkpoints": CloneCheckpoint,
    "people": MapPeople,
    "counts": PeopleCount,
    "tasks": MapTask,
    "buildings": BuildingRecord,
    "webhooks": Webhook,
    "deliveries": WebhookDelivery,
    "plans": PlanRecord,
    "history": PlannerHistory,
    "links": LinkHistory,
    "maps": MapHistory,
}
"""Types of the records by kind."""

EPOCHS = 1 << 20
"""Epochs by which a restored lease is ahead: machines obey no earlier epoch than they have seen since the backup."""


class Archive:
    """A backup, with the methods of stores that copying calls.

    Parameters
    ----------
    repository : Repository
    manifest : BackupManifest
        The backup.
    """

    def __init__(self, repository: Repository, manifest: BackupManifest) -> None:
        self._repository = repository
        self.manifest = manifest
        self._page: dict[Key, Any] = {}
        self._logs = {(log.user, log.robot, log.log): log for log in manifest.logs}

    def pages(self, kind: str) -> Iterator[list[Key]]:
        """Yield the keys of the records of a kind, block by block; ``page`` has the records meanwhile."""
        for block in self.manifest.streams[kind].blocks:
            entries = self._entries(block, RECORDS[kind])
            self._page = {_key(key): record for key, record in entries}
            yield list(self._page)

    def page(self, keys: Sequence[Key]) -> dict[Key, Any]:
        """Return the records of the current page among these keys."""
        return {key: self._page[key] for key in keys if key in self._page}

    def key_of(self, record: Any) -> Key:
        """Return the key of a record of the current page."""
        return next(key for key, found in self._page.items() if found is record)

    def clone_logs(self, user: str, robot: str) -> list[str]:
        """Return the names of the logs of a clone, sorted."""
        return sorted(log for owner, of, log in self._logs if (owner, of) == (user, robot))

    def clone_log(
        self, user: str, robot: str, log: str, *, after: int = -1, limit: int | None = None
    ) -> list[tuple[int, bytes]]:
        """Return the entries of a log in one of its blocks, the first that has later ones than ``after``."""
        for block in self._logs[user, robot, log].blocks:
            entries = [entry for entry in self._entries(block, bytes) if entry[0] > after]
            if entries:
                return entries[:limit]
        return []

    @contextmanager
    def open_map(self, map_id: str, version: str | None = None, *, only: Collection[str] = PARTS) -> Iterator[OpenMap]:
        """Open a version of a map for reading; as ``MapStore.open_map``."""
        parts = self.manifest.versions.get(version or "")
        if parts is None:
            raise NotFound(f"version of map {map_id!r}:", version or "")
        with temporary_folder() as folder:
            paths = {part: self._file(folder / part, stored) for part, stored in parts.items() if part in only}
            buffers: dict[str, Buffer] = {part: mapped(path) for part, path in paths.items()}
            record = MapRecord(map_id, "", MapVersionRecord(0, version or "", 0.0, ""))
            yield OpenMap(record, paths, buffers)

    def _file(self, path: Path, stored: StoredPart) -> Path:
        digest = hashlib.sha256()
        with path.open("wb") as file:
            for name in stored.blocks:
                data = self._repository.block(name)
                digest.update(data)
                file.write(data)
        if digest.hexdigest() != stored.sha256:
            raise damaged(f"{path.name} of a map in backup {self.manifest.id}", "its hash differs")
        return path

    def _entries(self, block: Block, kind: Any) -> list[Any]:
        """Return the records of a block, each with its key."""
        entries: Any = list[tuple[Any, kind]]
        try:
            return list(from_msgpack(self._repository.block(block.name), entries))
        except msgspec.MsgspecError as error:
            raise damaged(f"block {block.name} of backup {self.manifest.id}", error) from error

    def verify(self) -> Iterator[str]:
        """Read all blocks; yield a description of each that is damaged.

        Raises
        ------
        Unavailable
            The repository cannot be read.
        """
        for name in sorted(self.manifest.blocks()):
            try:
                self._repository.block(name)
            except Damaged as error:
                yield str(error)


@dataclass(slots=True)
class LeftOut:
    """Records of a kind that were not restored, because what they belong to is not in the backup."""

    kind: str
    keys: list[Key]


def kinds_of(archive: Archive, kinds: Sequence[StoredKind[Any]], left_out: list[LeftOut]) -> list[StoredKind[Any]]:
    """Return the kinds of records that an archive has, so that copying and comparing can read it as their source.

    Parameters
    ----------
    archive : Archive
    kinds : sequence of StoredKind
    left_out : list of LeftOut
        Gets the records that cannot be restored. A store that changed while it was read may have had a robot of a
        user who was removed by then.
    """
    return [_kind_of(archive, kind, left_out) for kind in kinds if kind.name in archive.manifest.streams]


def _kind_of(archive: Archive, kind: StoredKind[Any], left_out: list[LeftOut]) -> StoredKind[Any]:
    missing: list[Key] = []
    left_out.append(LeftOut(kind.name, missing))

    def pages(store: Any) -> Iterator[list[Key]]:
        return archive.pages(kind.name) if store is archive else kind.pages(store)

    def read(store: Any, keys: Sequence[Key]) -> dict[Key, Any]:
        if store is not archive:
            return kind.read(store, keys)
        return {key: record for key, record in archive.page(keys).items() if key not in missing}

    def add(source: Any, target: Any, records: Sequence[Any]) -> None:
        try:
            kind.add(source, target, records)
        except NotFound:
            for record in records:
                try:
                    kind.add(source, target, [record])
                except NotFound:
                    missing.append(archive.key_of(record))

    count = archive.manifest.streams[kind.name].records
    return replace(kind, pages=pages, read=read, add=add, count=lambda _: count, verify=None)


def restore_epochs(manifest: BackupManifest, store: Store) -> None:
    """Set the epochs of leases beyond any that a machine can have seen."""
    for name, epoch in manifest.epochs.items():
        held = store.lease(name)
        store.change_lease(Lease(name, epoch=max(held.epoch, epoch) + EPOCHS), instead_of=held)


def _key(value: Any) -> Key:
    return tuple(value) if isinstance(value, list) else value
