"""Paths that an endpoint counts without asking the master for each: paths of users who request many at once."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from ppaas.bounded import BoundedDict
from ppaas.clock import Clock

AHEAD = 64
"""Number of paths that an endpoint counts ahead of their requests."""

BUSY = 0.1
"""Time between two requests of a user below which paths are counted ahead [s]."""

KEEP = 1.0
"""Time for which they may be requested [s]; the quota is restored as if they had been."""

MAX_USERS = 10_000
"""Number of users who are known here; those whose requests are oldest are forgotten first."""

Take = Callable[[str, int, int], Awaitable[int]]
"""Counts paths of a user and, if the quota allows, a number of further ones; returns how many further ones."""


@dataclass(slots=True)
class _Counted:
    left: int = 0
    until: float = 0.0
    last: float = float("-inf")
    asking: bool = False


class PathsAhead:
    """Counts paths of users here, as far as the master has counted them already.

    Parameters
    ----------
    take : callable
        Counts paths in the master; raises ``QuotaExceeded``.
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(self, take: Take, clock: Clock) -> None:
        self._take = take
        self._clock = clock
        self._users: BoundedDict[str, _Counted] = BoundedDict(MAX_USERS)

    def forget(self, user: str) -> None:
        """Count the next path of a user in the master, since the quota has changed."""
        self._users.pop(user, None)

    async def count(self, user: str, paths: int) -> None:
        """Count paths that a user requests; raises the errors of ``take``."""
        now = self._clock()
        counted = self._users.get(user)
        if counted is None:
            counted = self._users[user] = _Counted()
        is_busy, counted.last = now - counted.last < BUSY, now
        if now >= counted.until:
            counted.left = 0
        if paths <= counted.left:
            counted.left -= paths
            return
        asks = is_busy and not counted.asking  # one at a time, or each of many clients would take as many
        counted.asking = counted.asking or asks
        try:
            more = await self._take(user, paths, AHEAD if asks else 0)
        finally:
            counted.asking = counted.asking and not asks
        if more:
            counted.left, counted.until = counted.left + more, self._clock() + KEEP
