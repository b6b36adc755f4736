"""File of tokens that were revoked and cannot be removed from the store yet. Its size never changes.

It is written in place, so that a revocation can be kept on a full disk.
"""

import contextlib
import logging
import os
import threading
import zlib
from pathlib import Path

import msgspec

from ppaas.decoding import from_msgpack
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

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
