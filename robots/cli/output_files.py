"""Files that commands write."""

from pathlib import Path

from ppaas.errors import InvalidInput


def check_folder(path: Path) -> None:
    """Check, before long work, that the folder of a file exists.

    Raises
    ------
    InvalidInput
        There is no such folder.
    """
    if not path.parent.is_dir():
        raise InvalidInput(f"cannot write {path}: there is no folder {path.parent}")


def write_file(path: Path, content: bytes) -> None:
    """Write a file, or replace it.

    Raises
    ------
    InvalidInput
        It cannot be written.
    """
    try:
        path.write_bytes(content)
    except OSError as error:
        raise InvalidInput(f"cannot write the file: {error}") from error
