"""Disk space: a reserve of it, stores that store nothing new without it, and revocations that need none.

The reserve is a file that is removed when the disk is full, so that space can still be freed. While it is set aside,
everything is stored. When the disk is full, it is given up: tokens can then still be issued and revoked, and data
removed, but nothing else is stored (`GuardedStore`) until there is space for a new reserve. All processes of a cloud on
this machine check for the file itself.
"""

import contextlib
import logging
import os
import threading
import zlib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal, NamedTuple

import msgspec

from ppaas.decoding import from_msgpack
from ppaas.errors import Unavailable
from storage.ports import MapStore, Store

logger = logging.getLogger(__name__)


RESERVE = "disk-reserve"
"""Name of the reserve in a data folder."""

MIN_RESERVE, MAX_RESERVE, RESERVE_FRACTION = 1 << 20, 16 << 20, 0.01
"""Bounds of its size [bytes], and its size in proportion to the disk."""

LOW, LOW_FRACTION = 1 << 30, 0.05
"""Free space that counts as low: the smaller of a size [bytes] and a fraction of the disk."""

MIN_FREE_FRACTION = 0.25
"""Free space below which the disk counts as full, in proportion to the reserve."""

SpaceState = Literal["ok", "low", "full"]


class DiskSpace(NamedTuple):
    """Size and free space of a disk for this user [bytes], and the number of files that can be created."""

    total: int
    free: int
    files: int

    @classmethod
    def of(cls, folder: Path) -> "DiskSpace":
        """Measure the disk of a folder; ``OSError`` if it cannot be measured."""
        found = os.statvfs(folder)
        files = found.f_favail if found.f_files else 1  # some file systems have no limit and report no numbers
        return cls(found.f_blocks * found.f_frsize, found.f_bavail * found.f_frsize, files)


class DiskReserve:
    """The reserve on the disk of a folder. Thread-safe.

    Parameters
    ----------
    folder : Path
        The data folder.
    measure : callable
        Measures the disk of a folder; raises ``OSError`` if it cannot be measured.
    """

    def __init__(self, folder: Path, measure: Callable[[Path], DiskSpace] = DiskSpace.of) -> None:
        self._folder = folder
        self._file = folder / RESERVE
        self._measure = measure
        self._lock = threading.Lock()

    def size(self, space: DiskSpace) -> int:
        """Return the size of the reserve for a disk [bytes]."""
        return int(min(max(MIN_RESERVE, RESERVE_FRACTION * space.total), MAX_RESERVE))

    def space(self) -> DiskSpace:
        """Measure the disk; ``OSError`` if it cannot be measured."""
        return self._measure(self._folder)

    def state(self) -> SpaceState:
        """Return the state of the disk: full if the reserve was given up, or nearly no space is left beside it."""
        space = self.space()
        if self._is_used_up(space) or not self._file.exists():
            return "full"
        return "low" if space.free < min(LOW, LOW_FRACTION * space.total) else "ok"

    def is_full(self) -> bool:
        """Return whether the disk is full; a disk that cannot be measured is not."""
        try:
            return self.state() == "full"
        except OSError:
            return False

    def keep(self) -> SpaceState:
        """Give the reserve up if the disk is full, and set it aside if there is space; return the new state.

        Only the owner of the data folder calls this, when it starts and then every second.
        """
        with self._lock:
            space = self.space()
            if self._is_used_up(space):
                self._file.unlink(missing_ok=True)
            elif not self._file.exists() and space.free >= 2 * self.size(space):
                self._set_aside(self.size(space))
            return self.state()

    def release(self) -> None:
        """Remove the reserve when the owner of the data folder ends; does nothing if the disk fails."""
        with self._lock, suppress(OSError):
            self._file.unlink(missing_ok=True)

    def _is_used_up(self, space: DiskSpace) -> bool:
        return space.free < MIN_FREE_FRACTION * self.size(space) or space.files < 1

    def _set_aside(self, size: int) -> None:
        partial = self._file.with_name(f"{RESERVE}.partial")
        try:
            handle = os.open(partial, os.O_WRONLY | os.O_CREAT, 0o600)
            try:
                os.posix_fallocate(handle, 0, size)
            finally:
                os.close(handle)
            partial.replace(self._file)
        except OSError:  # the space was taken meanwhile
            with suppress(OSError):
                partial.unlink(missing_ok=True)


# Stores on a local disk that store nothing new while the disk is full.
#
# Calls that free space or withdraw a right still work: tokens, passwords, roles and limits of users, the readers of
# maps, and all removals. They need little space, which the reserve provides (``storage.disk_space``).

REFUSED = frozenset(
    {
        "add_user",
        "put_robot",
        "put_urdf",
        "add_plan",
        "add_plans",
        "replace_plan",
        "save_clone",
        "add_history",
        "put_link",
        "add_people_counts",
        "stage",
        "publish",
        "propose",
        "approve",
        "roll_back",
    }
)
"""Methods of both ports that a full disk refuses."""

FULL = (
    "the disk of the cloud is full: an administrator must free space, for example by removing maps or plans; robots "
    "drive on, and rights can be withdrawn"
)


class GuardedStore:
    """A ``Store`` or a ``MapStore`` on a local disk. Calls that a full disk refuses raise ``Unavailable``.

    Parameters
    ----------
    store : Store or MapStore
    reserve : DiskReserve
        Reserve on the same disk.
    """

    def __init__(self, store: Store | MapStore, reserve: DiskReserve) -> None:
        self._store = store
        self._reserve = reserve

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the store; a method that a full disk refuses checks the disk first."""
        found = getattr(self._store, name)
        if name not in REFUSED:
            return found
        guarded = self._checked(found)
        setattr(self, name, guarded)
        return guarded

    def _checked(self, method: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            if self._reserve.is_full():
                raise Unavailable(FULL)
            return method(*arguments, **options)

        return call


# File of tokens that were revoked and cannot be removed from the store yet. Its size never changes.
#
# It is written in place, so that a revocation can be kept on a full disk.

REFUSED_TOKENS = "refused-tokens"
"""Name of the file in a data folder."""

SLOT, SLOTS = 256, 1024
"""Size of the place of a token [bytes], which no write to a disk divides, and their number."""

_CHECKSUM = 4

RefusedToken = tuple[str, str]
"""User and hash of a token."""


class RefusedTokenFile:
    """Tokens on the disk. Thread-safe; one process uses the file at a time.

    Parameters
    ----------
    folder : Path
        The data folder.
    slots : int
        Number of tokens that there is space for.
    """

    def __init__(self, folder: Path, slots: int = SLOTS) -> None:
        self._path, self._slots = folder / REFUSED_TOKENS, slots
        self._lock = threading.Lock()
        self._used: dict[RefusedToken, int] = {}
        self._is_there = False

    def open(self) -> list[RefusedToken]:
        """Create the file if it is missing, and return the tokens in it; without space for it, none are kept."""
        with self._lock:
            try:
                if not self._path.exists():
                    self._create()
                content = self._path.read_bytes()
            except OSError as error:
                logger.error("revoked tokens cannot be kept in %s while the disk is full: %s", self._path, error)
                return []
            self._is_there, self._slots = True, len(content) // SLOT
            found = ((at, _read(content[at * SLOT : (at + 1) * SLOT])) for at in range(self._slots))
            self._used = {token: at for at, token in found if token is not None}
            return list(self._used)

    def _create(self) -> None:
        partial = self._path.with_name(f"{REFUSED_TOKENS}.partial")
        try:
            handle = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
            with os.fdopen(handle, "wb") as file:  # zeros take space, which a file with holes would not
                file.write(bytes(SLOT * self._slots))
                file.flush()
                os.fsync(file.fileno())
            partial.replace(self._path)
        finally:
            with contextlib.suppress(OSError):
                partial.unlink(missing_ok=True)

    def add(self, user: str, token_hash: str) -> None:
        """Keep a token; does nothing if it is kept already.

        Raises
        ------
        Unavailable
            It cannot be kept: there is no file or no space in it, or the disk fails.
        """
        token = user, token_hash
        with self._lock:
            if token in self._used:
                return
            taken = set(self._used.values())
            free = next((at for at in range(self._slots) if at not in taken), None) if self._is_there else None
            if free is None:
                raise _not_kept("there is no space for it")
            try:
                self._write(free, _written(token))
            except OSError as error:
                raise _not_kept(str(error)) from error
            self._used[token] = free

    def remove(self, user: str, token_hash: str) -> None:
        """Forget a token, which was removed from the store. If that cannot be written, it is forgotten at a restart."""
        with self._lock:
            at = self._used.pop((user, token_hash), None)
            if at is not None:
                try:
                    self._write(at, bytes(SLOT))
                except OSError as error:
                    logger.warning("a token that was removed stays in %s: %s", self._path, error)

    def _write(self, at: int, data: bytes) -> None:
        handle = os.open(self._path, os.O_WRONLY)
        try:
            os.pwrite(handle, data, at * SLOT)
            os.fdatasync(handle)
        finally:
            os.close(handle)


def _written(token: RefusedToken) -> bytes:
    data = msgspec.msgpack.encode(token)
    return (zlib.crc32(data).to_bytes(_CHECKSUM) + data).ljust(SLOT, b"\0")


def _read(slot: bytes) -> RefusedToken | None:
    """Return the token in a slot; None if it is empty, or was not written to its end."""
    data = slot[_CHECKSUM:].rstrip(b"\0")
    if not data or zlib.crc32(data) != int.from_bytes(slot[:_CHECKSUM]):
        return None
    token: RefusedToken = from_msgpack(data, RefusedToken)
    return token


def _not_kept(reason: str) -> Unavailable:
    return Unavailable(
        f"the token is refused until the cloud restarts, and the revocation could not be stored ({reason}): revoke it "
        "again when there is space",
        public="the token is refused, but the revocation is not stored: revoke it again later",
    )
