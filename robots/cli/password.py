"""Password input from a file, the terminal or a pipe. Never from the command line, which other users can see."""

import argparse
import getpass
import sys
from pathlib import Path

from ppaas.errors import InvalidInput


def add_password_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option for a password file."""
    parser.add_argument(
        "--password-file", type=Path, help="file with the password (prompt, or standard input if it is a pipe)"
    )


def read_password(user: str, file: Path | None) -> str:
    """Read the password of a user.

    Raises
    ------
    InvalidInput
        The file cannot be read, or the password is empty.
    """
    if file is not None:
        password = _read(file)
    elif sys.stdin.isatty():
        password = getpass.getpass(f"password of {user}: ", sys.stderr)
    else:
        password = sys.stdin.readline().rstrip("\r\n")
    if not password:
        raise InvalidInput(f"password of {user!r} is empty; type it, pipe it in, or use --password-file FILE")
    return password


def read_secret(kind: str, file: Path) -> str:
    """Read a secret from a file, or from standard input if it is ``-``.

    Raises
    ------
    InvalidInput
        The file cannot be read or is empty.
    """
    secret = sys.stdin.read().strip() if str(file) == "-" else _read(file)
    if not secret:
        raise InvalidInput(f"the {kind} in {file} is empty")
    return secret


def _read(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8-sig").strip()  # editors of Windows write a byte-order mark
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"cannot read {file}: {error}") from error
