"""Translation of errors of HDFS and its client into ``Unavailable`` with advice for the operator."""

from collections.abc import Iterator
from contextlib import contextmanager

from hdfs import HdfsError
from requests import RequestException

from storage.hdfs.address import HdfsAddress
from storage.store_errors import unusable

_STARTING = "the NameNode is starting or in standby: wait, or give the address of the active one"
_QUOTA = "the quota of the folder is used up: free space, or raise the quota"
_ADVICE = {
    "AccessControlException": "permission denied: give user {user!r} read and write access, or set another ?user=name",
    "SecurityException": "user {user!r} is refused: set another one with ?user=name",
    "SafeModeException": "HDFS is in safe mode: wait until its DataNodes have reported, or end safe mode",
    "RetriableException": _STARTING,
    "StandbyException": _STARTING,
    "DSQuotaExceededException": _QUOTA,
    "NSQuotaExceededException": _QUOTA,
}
_MISSING = "FileNotFoundException"
_MAX_TEXT = 200


@contextmanager
def hdfs_errors(address: HdfsAddress) -> Iterator[None]:
    """Turn errors of the client into ``Unavailable``, and those for a missing file into ``FileNotFoundError``."""
    try:
        yield
    except HdfsError as error:
        if error.exception == _MISSING:
            raise FileNotFoundError(str(error)) from error
        raise unusable(address, _advice(error, address)) from error
    except RequestException as error:
        reason = type(error).__name__
        raise unusable(
            address, f"cannot reach the NameNode or a DataNode ({reason}): check that both are running"
        ) from error
    except (KeyError, TypeError) as error:
        raise unusable(address, "the server does not speak WebHDFS: give the HTTP port of the NameNode") from error


def _advice(error: HdfsError, address: HdfsAddress) -> str:
    known = _ADVICE.get(error.exception or "")
    if known is not None:
        return known.format(user=address.user)
    return f"HDFS failed ({str(error)[:_MAX_TEXT]}): check that its DataNodes are running and have free space"
