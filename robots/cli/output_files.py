"""Files that commands write."""

import os
import shutil
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
    """Write a file, or replace it: it is whole, or as it was before, also if the command is interrupted.

    Raises
    ------
    InvalidInput
        It cannot be written.
    """
    target = path.resolve()
    try:
        if target.exists() and not target.is_file():  # such as /dev/stdout
            target.write_bytes(content)
            return
        part = target.with_name(f"{target.name}.{os.getpid()}.part")
        try:
            part.write_bytes(content)
            if target.exists():
                shutil.copymode(target, part)
            part.replace(target)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        raise InvalidInput(f"cannot write the file: {error}") from error
