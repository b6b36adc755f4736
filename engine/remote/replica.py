"""Files that a standby needs to lead in place of another host's process: certificates, tickets, settings of machines.

With them it proves itself to machines as the same cloud. They include the key of the certificate authority, so a
standby must be protected like the data folder of the cloud.
"""

import re
from collections.abc import Iterable
from pathlib import Path

from engine.processes.private_files import write_private
from ppaas.errors import InvalidInput, MalformedMessage

MACHINES = "machines"
"""Folder of certificates and tickets in a data folder."""

FOLDERS = (MACHINES, f"{MACHINES}/issued", f"{MACHINES}/tickets")
"""Folders of the files, without the data folder itself."""

NAMES = re.compile(
    r"machine-settings\.json|machines-here\.json"
    rf"|{MACHINES}/(authority\.key|authority\.pem|cloud\.key|cloud\.pem|fabric\.json|masters\.json)"
    rf"|{MACHINES}/issued/[A-Za-z0-9][A-Za-z0-9._-]{{0,63}}\.pem"
    rf"|{MACHINES}/tickets/[0-9a-f]{{64}}\.json"
)
"""Names of the files, relative to the data folder."""

LAST = f"{MACHINES}/cloud.pem"
"""File whose existence shows that the certificate authority is complete."""


def names_in(data: Path) -> list[str]:
    """Return the names of the files in a data folder."""
    folders = (data, *(data / name for name in FOLDERS))
    paths = (path for folder in folders for path in (sorted(folder.iterdir()) if folder.is_dir() else ()))
    return [name for path in paths if NAMES.fullmatch(name := path.relative_to(data).as_posix())]


def read_files(data: Path) -> dict[str, bytes]:
    """Return the files in a data folder by name; those that disappear meanwhile are left out.

    Raises
    ------
    InvalidInput
        A file cannot be read.
    """
    found: dict[str, bytes] = {}
    for name in names_in(data):
        try:
            found[name] = (data / name).read_bytes()
        except FileNotFoundError:
            continue
        except OSError as error:
            raise InvalidInput(f"cannot read {data / name} for the standbys: {error}") from error
    return found


def signature(data: Path) -> tuple[int, ...]:
    """Return numbers that change when a file is added, replaced or removed: all files are replaced as a whole."""
    folders = (data, *(data / name for name in FOLDERS))
    return tuple(folder.stat().st_mtime_ns for folder in folders if folder.is_dir())


def in_order(names: set[str]) -> list[str]:
    """Return names in the order in which they are stored: the one that shows that all are there comes last."""
    return sorted(names, key=lambda name: (name == LAST, name))


def write_file(data: Path, name: str, content: bytes) -> None:
    """Store a file.

    Raises
    ------
    MalformedMessage
        No file of this name is replicated.
    InvalidInput
        The file cannot be stored.
    """
    if NAMES.fullmatch(name) is None:
        raise MalformedMessage(f"{name[:80]!r} is no file of a standby")
    path = data / name
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_private(path, content)
    except OSError as error:
        raise InvalidInput(f"cannot store {path}: {error}") from error


def keep_only(data: Path, names: Iterable[str]) -> None:
    """Remove the files that have other names than these; ``InvalidInput`` if one cannot be removed."""
    for name in read_files(data).keys() - set(names):
        try:
            (data / name).unlink(missing_ok=True)
        except OSError as error:
            raise InvalidInput(f"cannot remove {data / name}: {error}") from error
