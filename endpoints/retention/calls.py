"""Calls of endpoints about retention, which the process of the master sees to."""

from typing import Protocol

import msgspec


class RetentionView(msgspec.Struct, frozen=True):
    """Retention of a kind of data.

    Parameters
    ----------
    kind, text : str
        Name, and what it is.
    days : float, optional
        Age beyond which it is removed [days]; None if it is kept however old it is.
    last_run : float, optional
        Time at which this process removed what had expired [s since the epoch]; None before.
    removed : int, optional
        Number that was removed then; None if that failed, or before.
    gigabytes : float, optional
        Size beyond which the oldest are removed [GB]; None if it is not limited.
    """

    kind: str
    text: str
    days: float | None
    last_run: float | None = None
    removed: int | None = None
    gigabytes: float | None = None


class ExpiredData(msgspec.Struct, frozen=True):
    """What has expired of a kind, and was removed unless it was a dry run.

    Parameters
    ----------
    kind : str
    before : float
        What is older than this time has expired [s since the epoch]; 0 if only its size is limited.
    expired : int
        Number of recordings, events, counts, plans, tasks or deliveries.
    fault : str
        Why it could not be looked for or removed; empty if it could.
    """

    kind: str
    before: float
    expired: int = 0
    fault: str = ""


class RetentionCalls(Protocol):
    """Calls of endpoints about retention."""

    async def views(self) -> list[RetentionView]:
        """Return for how long each kind of data is kept."""
        ...

    async def expire(self, dry_run: bool) -> list[ExpiredData]:
        """Remove what has expired, or only count it; return what it is."""
        ...
