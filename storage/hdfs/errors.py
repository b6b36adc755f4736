"""What HDFS says when it cannot, as ``Unavailable`` with a text that says what to do."""

from collections.abc import Iterator
from contextlib import contextmanager

from hdfs import HdfsError
from requests import RequestException

from ppaas.errors import Unavailable
from storage.hdfs.address import HdfsAddress

_STARTING = "the NameNode is starting, or stands by for another: wait, or name the active one"
_QUOTA = "the quota of the folder is used up: free space, or raise it"
_ADVICE = {
    "AccessControlException": "permission denied: let the user {user!r} read and write the folder, or name another",
    "SecurityException": "the user {user!r} is refused: name another, as in ?user=name",
    "SafeModeException": "HDFS is in safe mode: wait until its DataNodes have reported, or have it leave that mode",
    "RetriableException": _STARTING,
    "StandbyException": _STARTING,
    "DSQuotaExceededException": _QUOTA,
    "NSQuotaExceededException": _QUOTA,
}
_MISSING = "FileNotFoundException"
_LONGEST = 200


@contextmanager
def hdfs_errors(address: HdfsAddress) -> Iterator[None]:
    """Turn what the client raises in the block into ``Unavailable``; a missing file into ``FileNotFoundError``."""
    try:
        yield
    except HdfsError as error:
        if error.exception == _MISSING:
            raise FileNotFoundError(str(error)) from error
        raise Unavailable(f"{address}: {_advice(error, address)}") from error
    except RequestException as error:
        why = type(error).__name__
        raise Unavailable(f"{address}: cannot reach the NameNode or a DataNode ({why}): see that both run") from error
    except (KeyError, TypeError) as error:
        raise Unavailable(
            f"{address}: what answers there does not speak WebHDFS: is it the NameNode's port?"
        ) from error


def _advice(error: HdfsError, address: HdfsAddress) -> str:
    known = _ADVICE.get(error.exception or "")
    if known is not None:
        return known.format(user=address.user)
    return f"HDFS fails ({str(error)[:_LONGEST]}): see that its DataNodes run and have space"
