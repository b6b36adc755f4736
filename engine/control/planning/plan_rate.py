"""Rate limit of path requests: the quota ``plans_per_minute`` of each user."""

import math

from engine.master.quotas import Quotas
from ppaas.clock import Clock, monotonic
from ppaas.errors import QuotaExceeded

WINDOW = 60.0
"""Period of the quota [s]. A whole quota may be used at once; it is then restored at a constant rate."""

MAX_KNOWN = 4096
"""Number of users in memory above which users with a full quota are forgotten."""


AHEAD_SHARE = 1000
"""An endpoint may count one in so many paths of a quota before they are requested."""


class PlanRate:
    """Counts path requests by the generic cell rate algorithm, a token bucket with one number per user.

    The number is the time at which the user's quota is full again. A request advances it by the share of the quota that
    it uses, times the period. A request that would advance it to more than one period from now is refused, and leaves
    it unchanged. See ITU-T I.371, annex A.

    Parameters
    ----------
    quotas : Quotas
        Quotas of the users.
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(self, quotas: Quotas, clock: Clock = monotonic) -> None:
        self._quotas = quotas
        self._clock = clock
        self._whole: dict[str, float] = {}

    def take(self, user: str, plans: int = 1) -> None:
        """Count paths that a user requests.

        Raises
        ------
        QuotaExceeded
            They exceed the quota; ``retry_after`` is the time until they are allowed [s], None if they never are.
        """
        limit, now = self._quotas.of(user).plans_per_minute, self._clock()
        used = max(self._whole.get(user, now) - now, 0.0)
        after = used + plans * WINDOW / limit if limit else math.inf
        if after > WINDOW:
            retry = after - WINDOW if plans <= limit else None
            raise QuotaExceeded(_too_many(user, limit, self.used(user), plans, retry), retry_after=retry)
        self._whole[user] = now + after
        if len(self._whole) > MAX_KNOWN:
            self._whole = {name: whole for name, whole in self._whole.items() if whole > now}

    def take_ahead(self, user: str, plans: int, ahead: int) -> int:
        """Count paths that a user requests, and others that it may request soon; return the number of these.

        They are a thousandth of the quota at most, and none if the quota would be exceeded. Raises as ``take``.
        """
        self.take(user, plans)
        more = min(ahead, self._quotas.of(user).plans_per_minute // AHEAD_SHARE)
        try:
            self.take(user, more)
        except QuotaExceeded:
            return 0
        return more

    def used(self, user: str) -> int:
        """Return the number of paths that currently count against a user's quota."""
        now = self._clock()
        seconds = max(self._whole.get(user, now) - now, 0.0)
        return math.ceil(round(seconds * self._quotas.of(user).plans_per_minute / WINDOW, 6))


def _too_many(user: str, limit: int, used: int, plans: int, retry: float | None) -> str:
    text = (
        f"user {user!r} may request {limit} paths a minute and has used {used}; {plans} more would exceed the limit: "
    )
    if retry is None:
        return f"{text}request fewer at once, or ask an administrator to raise the quota 'plans_per_minute'"
    return f"{text}try again in {retry:.3g} s, or ask an administrator to raise the quota 'plans_per_minute'"
