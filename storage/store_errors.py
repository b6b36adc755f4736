"""Errors of stores: the text for operators names the file or the address, the text for clients does not."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ppaas import __version__
from ppaas.errors import Damaged, Unavailable

NO_STORE = "a store of this cloud cannot be used now: try again later"
"""Text for clients; the reason is for the administrators, who read it in the log and with the health."""


def unusable(place: object, advice: str, public: str = NO_STORE) -> Unavailable:
    """Return the error of a store that cannot be used.

    Parameters
    ----------
    place : object
        File or address of the store.
    advice : str
        Description of the fault, with advice, for operators.
    public : str
        The same for clients.
    """
    return Unavailable(f"{place}: {advice}", public=public)


def damaged(place: str, reason: object) -> Damaged:
    """Return the error of a record that cannot be read."""
    return Damaged(f"{place} is damaged ({reason}): restore it from a backup")


def of_another_release(place: str, release: str, reason: object) -> Unavailable:
    """Return the error of a record that is as it was written, and that this release cannot read.

    Parameters
    ----------
    place : str
        Table and key of the record.
    release : str
        Release that wrote it; empty if the record does not name it.
    reason : object
        What this release cannot read.
    """
    return Unavailable(
        f"{place} is a record of another release of PPaaS ({release or 'unknown'}), which this one ({__version__}) "
        f"cannot read ({reason}): run the release that wrote it, or a newer one"
    )


# Errors of disks, with advice for the operator.

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
