"""Where a password comes from: a file, the terminal, or a pipe; never the command line, which others can see."""

import argparse
import getpass
import sys
from pathlib import Path

from ppaas.errors import InvalidInput


def add_password_argument(parser: argparse.ArgumentParser) -> None:
    """Add the file that the password may be in."""
    parser.add_argument(
        "--password-file", type=Path, help="file with the password; without it you are asked, or it is read from a pipe"
    )


def read_password(user: str, file: Path | None) -> str:
    """Return the password of a user.

    Raises
    ------
    InvalidInput
        The file cannot be read, or there is no password.
    """
    if file is not None:
        password = _read(file)
    elif sys.stdin.isatty():
        password = getpass.getpass(f"password of {user}: ", sys.stderr)
    else:
        password = sys.stdin.readline().rstrip("\r\n")
    if not password:
        raise InvalidInput(f"no password for {user!r}: type it, pipe it in, or give --password-file FILE")
    return password


def _read(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"cannot read the password file: {error}") from error
