"""What the operating system says of a disk, as ``Unavailable`` with a text that says what to do."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ppaas.errors import Unavailable

_ADVICE = {
    errno.ENOSPC: "the disk is full: free space",
    errno.EDQUOT: "the disk quota is used up: free space",
    errno.EROFS: "the file system is read-only: mount it writable",
    errno.EACCES: "permission denied: let the user that runs the cloud read and write it",
    errno.EPERM: "permission denied: let the user that runs the cloud read and write it",
    errno.EMFILE: "too many open files: raise the limit (ulimit -n)",
    errno.ENFILE: "too many open files on this machine: raise the limit (fs.file-max)",
    errno.EIO: "the disk fails: look at its health, and restore from a backup",
    errno.ENOTDIR: "a file is where a folder should be: move it away",
    errno.EEXIST: "a file is where a folder should be: move it away",
}


@contextmanager
def disk_errors(path: Path, *, but: type[OSError] | tuple[()] = ()) -> Iterator[None]:
    """Turn an ``OSError`` from inside the block into ``Unavailable``, but for those of one type."""
    try:
        yield
    except but:
        raise
    except OSError as error:
        advice = _ADVICE.get(error.errno or 0, error.strerror or str(error))
        raise Unavailable(f"{path}: {advice}") from error
