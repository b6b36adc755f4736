"""Compression and encryption of what a repository stores."""

import hashlib
import hmac
import os
import secrets
from pathlib import Path

import zstandard
from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDFExpand

from ppaas.errors import InvalidInput
from storage.store_errors import damaged, disk_errors

KEY_BYTES = 32
NONCE_BYTES = 12
LEVEL = 3
"""Level of zstd: the default; images of maps shrink to a tenth at some hundred MB/s."""

MAX_BLOCK = 64 << 20
"""Limit of a decompressed block [bytes]."""


class Sealing:
    """Names of blocks, and their bytes in the repository: compressed, and encrypted if there is a key.

    A block is named by its SHA-256, or with a key by its HMAC-SHA-256: who reads the repository without the key cannot
    guess contents by their names. Encryption is AES-256-GCM with a random nonce; the name is authenticated too, so a
    block that is stored under another name is refused.

    Parameters
    ----------
    key : bytes, optional
        Secret of 32 bytes; None does not encrypt.
    """

    def __init__(self, key: bytes | None = None) -> None:
        self._naming = None if key is None else _derived(key, b"names")
        self._cipher = None if key is None else AESGCM(_derived(key, b"blocks"))

    @property
    def fingerprint(self) -> str:
        """Text that differs for each key, and is empty without one."""
        return "" if self._naming is None else hmac.digest(self._naming, b"fingerprint", "sha256").hex()[:16]

    def name(self, data: bytes | memoryview) -> str:
        """Return the name of a block."""
        if self._naming is None:
            return hashlib.sha256(data).hexdigest()
        return hmac.new(self._naming, data, "sha256").hexdigest()

    def seal(self, name: str, data: bytes | memoryview) -> bytes:
        """Return the bytes to store."""
        packed = zstandard.ZstdCompressor(LEVEL, write_checksum=False).compress(data)
        if self._cipher is None:
            return packed
        nonce = os.urandom(NONCE_BYTES)
        return nonce + self._cipher.encrypt(nonce, packed, name.encode())

    def open(self, name: str, sealed: bytes) -> bytes:
        """Return the block that was sealed under a name.

        Raises
        ------
        Damaged
            The bytes are not the ones that were stored.
        """
        packed = sealed
        if self._cipher is not None:
            try:
                packed = self._cipher.decrypt(sealed[:NONCE_BYTES], sealed[NONCE_BYTES:], name.encode())
            except (InvalidTag, ValueError) as error:
                raise damaged(f"{name} of the backup", "it cannot be decrypted") from error
        try:
            return zstandard.ZstdDecompressor().decompress(packed, max_output_size=MAX_BLOCK)
        except zstandard.ZstdError as error:
            raise damaged(f"{name} of the backup", error) from error


def read_key(path: Path, *, create: bool = False) -> bytes:
    """Return the key in a file: 64 hexadecimal digits.

    Parameters
    ----------
    path : Path
    create : bool
        Whether a file that does not exist is created, with a new key, readable by its owner only.

    Raises
    ------
    InvalidInput
        The file does not exist, or has no key.
    Unavailable
        The file cannot be read or created.
    """
    if create and not path.exists():
        with disk_errors(path), os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(secrets.token_hex(KEY_BYTES) + "\n")
    try:
        with disk_errors(path, but=FileNotFoundError):
            key = bytes.fromhex(path.read_text(encoding="ascii"))
    except FileNotFoundError as error:
        raise InvalidInput(f"{path}: no such file: give the key with which the backups were made") from error
    except ValueError as error:
        raise InvalidInput(f"{path} is not the key of a backup: it has 64 hexadecimal digits") from error
    if len(key) != KEY_BYTES:
        raise InvalidInput(f"{path} is not the key of a backup: it has 64 hexadecimal digits")
    return key


def _derived(key: bytes, purpose: bytes) -> bytes:
    return HKDFExpand(SHA256(), KEY_BYTES, b"ppaas backup " + purpose).derive(key)
