"""Translation of ``OSError`` into ``Unavailable`` with advice for the operator."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from storage.store_errors import unusable

_ADVICE = {
    errno.ENOSPC: "the disk is full: free space",
    errno.EDQUOT: "the disk quota is used up: free space",
    errno.EROFS: "the file system is read-only: mount it writable",
    errno.EACCES: "permission denied: give the user that runs the cloud read and write access",
    errno.EPERM: "permission denied: give the user that runs the cloud read and write access",
    errno.EMFILE: "too many open files: raise the limit (ulimit -n)",
    errno.ENFILE: "too many open files on this machine: raise the limit (fs.file-max)",
    errno.EIO: "the disk fails: check its health, and restore from a backup",
    errno.ENOTDIR: "a file is where a folder should be: move it away",
    errno.EEXIST: "a file is where a folder should be: move it away",
}


@contextmanager
def disk_errors(path: Path, *, but: type[OSError] | tuple[()] = ()) -> Iterator[None]:
    """Turn an ``OSError`` raised in the block into ``Unavailable``, except one of type ``but``."""
    try:
        yield
    except but:
        raise
    except OSError as error:
        advice = _ADVICE.get(error.errno or 0, error.strerror or type(error).__name__)
        raise unusable(path, advice, advice) from error
