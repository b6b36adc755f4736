"""A repository of backups: a folder, or a bucket of S3, Google Cloud Storage or Azure, by the library obstore.

``ppaas-backup.json`` names the format. ``blocks/`` has blocks by name, each written once. ``manifests/`` has one object
for each backup, written last: a backup that was cut off is not listed, and the next one uses its blocks. ``lock.json``
exists while a process writes.
"""

import json
import os
import socket
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, cast
from urllib.parse import unquote, urlsplit

import msgspec
import obstore
from obstore.exceptions import AlreadyExistsError, BaseError
from obstore.store import LocalStore, ObjectStore, from_url

from ppaas import __version__
from ppaas.clock import epoch
from ppaas.decoding import from_msgpack
from ppaas.errors import Conflict, InvalidInput, NotFound, Unavailable
from storage.backup.manifest import FORMAT, FORMAT_OF_RECORDS, BackupManifest
from storage.backup.sealing import Sealing
from storage.store_errors import damaged, of_another_release

MARKER = "ppaas-backup.json"
LOCK = "lock.json"
BLOCKS, MANIFESTS = "blocks", "manifests"

STALE = 600.0
"""Age from which a lock that its process has not renewed is taken over [s]."""

WRITERS = 4
"""Blocks that are sealed and written at once."""


class Repository:
    """A repository of backups. Its methods block; one thread calls them.

    Parameters
    ----------
    store : ObjectStore
        Where its objects are.
    place : str
        Its URL, for errors.
    key : bytes, optional
        Key with which everything is encrypted.
    create : bool
        Whether an empty place becomes a repository.

    Raises
    ------
    NotFound
        There is no repository, and none is created.
    InvalidInput
        The key is missing, or another than the one of the repository.
    Unavailable
        The place cannot be read, or another release wrote it.
    """

    def __init__(self, store: ObjectStore, place: str, key: bytes | None = None, *, create: bool = False) -> None:
        self._store = store
        self._place = place
        self._sealing = Sealing(key)
        self._known: set[str] = set()
        self._writers = ThreadPoolExecutor(WRITERS, thread_name_prefix="backup")
        self._writing: list[Future[int]] = []
        self.added = 0
        """Bytes that this process has added."""
        self._check_marker(create=create)

    @classmethod
    def at(cls, url: str, key: bytes | None = None, *, create: bool = False) -> "Repository":
        """Open a repository.

        Parameters
        ----------
        url : str
            Path or ``file:`` URL of a folder, or the URL of a bucket with a prefix: ``s3:``, ``gs:`` or ``az:``.
            Credentials are taken from the environment, as the tools of these services do.
        key, create
            As for the class, which also documents the errors.
        """
        return cls(object_store(url, create=create), url, key, create=create)

    # -- blocks ----------------------------------------------------------------------------------------------------

    def put(self, data: bytes | memoryview) -> str:
        """Store a block, unless the repository has it; return its name. It is stored once ``settle`` returns."""
        name = self._sealing.name(data)
        if name not in self._known:
            self._known.add(name)
            while len(self._writing) >= 2 * WRITERS:
                self.added += self._writing.pop(0).result()
            self._writing.append(self._writers.submit(self._write, name, bytes(data)))
        return name

    def _write(self, name: str, data: bytes) -> int:
        sealed = self._sealing.seal(name, data)
        with self._errors():
            try:
                obstore.put(self._store, block_path(name), sealed, mode="create")
            except AlreadyExistsError:  # of a backup that was cut off
                return 0
        self._sync(block_path(name))
        return len(sealed)

    def settle(self) -> None:
        """Wait until all blocks are stored, on the disk too."""
        while self._writing:
            self.added += self._writing.pop(0).result()

    def block(self, name: str) -> bytes:
        """Return a block.

        Raises
        ------
        Damaged
            It is missing, or is not what was stored.
        Unavailable
            The repository cannot be read.
        """
        try:
            sealed = self._get(block_path(name))
        except FileNotFoundError as error:
            raise damaged(f"block {name} of {self._place}", "it is missing") from error
        data = self._sealing.open(name, sealed)
        if self._sealing.name(data) != name:
            raise damaged(f"block {name} of {self._place}", "its hash differs")
        return data

    # -- manifests -------------------------------------------------------------------------------------------------

    def add(self, manifest: BackupManifest) -> None:
        """Add a backup whose blocks are stored."""
        sealed = self._sealing.seal(manifest.id, msgspec.msgpack.encode(manifest))
        path = f"{MANIFESTS}/{manifest.id}"
        with self._errors():
            obstore.put(self._store, path, sealed, mode="create")
        self._sync(path)

    def ids(self) -> list[str]:
        """Return the ids of all backups, oldest first."""
        return sorted(meta["path"].rpartition("/")[2] for meta in self._list(MANIFESTS))

    def manifests(self) -> Iterator[BackupManifest]:
        """Yield the manifests of all backups, oldest first; errors are the same as for ``manifest``."""
        return map(self._manifest, self.ids())

    def manifest(self, backup_id: str) -> BackupManifest:
        """Return the manifest of a backup, or of the newest one for ``latest``.

        Raises
        ------
        NotFound
            There is no such backup.
        Damaged
            It cannot be read.
        Unavailable
            A newer release wrote it.
        """
        ids = self.ids()
        if backup_id == "latest" and ids:
            backup_id = ids[-1]
        if backup_id not in ids:
            raise NotFound("backup", backup_id, ids)
        return self._manifest(backup_id)

    def _manifest(self, backup_id: str) -> BackupManifest:
        data = self._sealing.open(backup_id, self._get(f"{MANIFESTS}/{backup_id}"))
        try:
            written = from_msgpack(data, _Format)
            if written.format > FORMAT:
                raise of_another_release(f"backup {backup_id}", written.release, f"format {written.format}")
            return from_msgpack(data, BackupManifest)
        except msgspec.MsgspecError as error:
            raise damaged(f"backup {backup_id} of {self._place}", error) from error

    def remove(self, backup_ids: list[str]) -> int:
        """Remove backups, and the blocks that no other one needs; return the number of blocks.

        Blocks of backups that were cut off are removed, too. The caller holds the lock.
        """
        with self._errors():
            for backup_id in backup_ids:
                obstore.delete(self._store, f"{MANIFESTS}/{backup_id}")
        unused = self._known.difference(*(manifest.blocks() for manifest in self.manifests()))
        paths = sorted(map(block_path, unused))
        with self._errors():
            for first in range(0, len(paths), 1000):
                obstore.delete(self._store, paths[first : first + 1000])
        self._known -= unused
        return len(unused)

    # -- lock ------------------------------------------------------------------------------------------------------

    @contextmanager
    def locked(self) -> Iterator["Renewal"]:
        """Hold the lock of the repository: one process writes at a time.

        Yields
        ------
        Renewal
            Its ``renew`` is called now and then, so that no other process believes that this one has died.

        Raises
        ------
        Conflict
            Another process holds it.
        """
        renewal = Renewal(self._store)
        with self._errors():
            try:
                renewal.take(mode="create")
            except AlreadyExistsError:
                self._refuse_unless_stale()
                renewal.take(mode="overwrite")
        self._known = {meta["path"].rpartition("/")[2] for meta in self._list(BLOCKS)}
        try:
            yield renewal
        finally:
            with suppress(BaseError, OSError):  # the next process takes it over
                obstore.delete(self._store, LOCK)

    def _refuse_unless_stale(self) -> None:
        try:
            lock = json.loads(self._get(LOCK))
        except (FileNotFoundError, ValueError):
            return
        age = epoch() - lock["renewed"]
        ours = lock["host"] == socket.gethostname()
        if age < STALE and not (ours and not Path(f"/proc/{lock['pid']}").exists()):
            raise Conflict(
                f"{self._place} is in use by process {lock['pid']} of {lock['host']}: wait for it; if it has died, for "
                f"{STALE:.0f} s"
            )

    # -- objects ---------------------------------------------------------------------------------------------------

    def _check_marker(self, *, create: bool) -> None:
        try:
            marker = json.loads(self._get(MARKER))
        except FileNotFoundError:
            if not create:
                raise NotFound("repository of backups", self._place) from None
            marker = {"format": FORMAT_OF_RECORDS, "release": __version__, "key": self._sealing.fingerprint}
            with self._errors():
                obstore.put(self._store, MARKER, json.dumps(marker).encode())
        except ValueError as error:
            raise damaged(f"{MARKER} of {self._place}", error) from error
        if marker["format"] > FORMAT:
            raise of_another_release(self._place, marker["release"], f"format {marker['format']}")
        if marker["key"] != self._sealing.fingerprint:
            given = "is encrypted with another key" if self._sealing.fingerprint else "is encrypted"
            advice = f"{given}: give its key" if marker["key"] else "is not encrypted: leave the key out"
            raise InvalidInput(f"{self._place} {advice}")

    def _get(self, path: str) -> bytes:
        with self._errors():
            return bytes(obstore.get(self._store, path).bytes())

    def _list(self, prefix: str) -> Iterator[Any]:
        with self._errors():
            for page in obstore.list(self._store, f"{prefix}/"):
                yield from page

    def _sync(self, path: str) -> None:
        """Write an object of a folder to the disk; a bucket has done so when it answers."""
        if isinstance(self._store, LocalStore) and self._store.prefix is not None:
            descriptor = os.open(Path(self._store.prefix) / path, os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)

    @contextmanager
    def _errors(self) -> Iterator[None]:
        """Raise ``Unavailable`` for errors of the library, but not where there is no such object, or there is one."""
        try:
            yield
        except (FileNotFoundError, AlreadyExistsError):
            raise
        except (BaseError, OSError) as error:
            reason = str(error).partition("\n")[0]
            raise Unavailable(f"backups at {self._place}: {reason}") from error


class Renewal:
    """The lock of a repository while this process holds it."""

    def __init__(self, store: ObjectStore) -> None:
        self._store = store
        self._renewed = 0.0

    def take(self, mode: str) -> None:
        """Write the lock."""
        self._renewed = epoch()
        lock = {"host": socket.gethostname(), "pid": os.getpid(), "renewed": self._renewed}
        obstore.put(self._store, LOCK, json.dumps(lock).encode(), mode=cast(Any, mode))

    def renew(self) -> None:
        """Write the lock again if that was long ago."""
        if epoch() - self._renewed > STALE / 10:
            self.take("overwrite")


class _Format(msgspec.Struct, frozen=True):
    """What each format of a manifest has."""

    format: int
    release: str = ""


def block_path(name: str) -> str:
    """Return the path of a block in a repository."""
    return f"{BLOCKS}/{name[:2]}/{name}"


def object_store(url: str, *, create: bool) -> ObjectStore:
    """Return the store of objects at a URL.

    Raises
    ------
    InvalidInput
        The URL has an unknown scheme, or lacks the name of a bucket.
    """
    parts = urlsplit(url)
    if parts.scheme in ("", "file"):
        path = Path(unquote(parts.path) if parts.scheme else url).absolute()
        if not create and not path.is_dir():
            raise NotFound("repository of backups", url)
        return LocalStore(path, mkdir=True)
    try:
        return from_url(url)
    except (BaseError, ValueError) as error:
        reason = str(error).partition("\n")[0]
        raise InvalidInput(f"{url}: {reason}: give a folder, or a URL of s3:, gs: or az:") from error
