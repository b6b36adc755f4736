"""Name of the process that holds a lease, the same for all processes that use one data folder after each other."""

import secrets
import socket
from pathlib import Path

import msgspec

from engine.processes.private_files import write_private
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput

FILE = "lease-holder.json"
"""File in the data folder with its identity."""

LONGEST_HOST, LONGEST_FOLDER = 64, 128
"""Characters of host and folder in the name."""


class _Identity(msgspec.Struct, frozen=True):
    host: str
    folder: str
    id: str


def holder_of(data: Path) -> str:
    """Return the name of the process that owns a data folder.

    A copy of the folder, in another place or on another host, gets another identity, since the process that uses the
    original may still run.

    Raises
    ------
    InvalidInput
        The identity cannot be stored.
    """
    host, folder = socket.gethostname()[:LONGEST_HOST], str(data.resolve())
    known = _read(data / FILE)
    if known is None or (known.host, known.folder) != (host, folder):
        known = _Identity(host, folder, secrets.token_hex(4))
        try:
            write_private(data / FILE, msgspec.json.encode(known))
        except OSError as error:
            raise InvalidInput(f"cannot write the identity of the data folder: {error}") from error
    return f"{host}:{folder[-LONGEST_FOLDER:]}#{known.id}"


def _read(file: Path) -> _Identity | None:
    try:
        return from_json(file.read_bytes(), _Identity)
    except (OSError, msgspec.DecodeError):
        return None
