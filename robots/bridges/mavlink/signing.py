"""Key of the signatures of MAVLink 2."""

import re
from hashlib import sha256
from pathlib import Path

from ppaas.errors import InvalidInput

_HEX = re.compile(r"[0-9A-Fa-f]{64}")


def key_of(path: Path) -> bytes:
    """Return the key of 32 bytes in a file: its hexadecimal digits, or the SHA-256 of its passphrase.

    Raises
    ------
    InvalidInput
        The file cannot be read, or is empty.
    """
    try:
        text = path.read_text().strip()
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"cannot read the key of {path}: {error}") from error
    if not text:
        raise InvalidInput(f"{path} has no key: write 64 hexadecimal digits or a passphrase into it")
    return bytes.fromhex(text) if _HEX.fullmatch(text) else sha256(text.encode()).digest()
