"""How many paths each user may ask for in a minute."""

import math

from engine.master.quotas import Quotas
from ppaas.clock import Clock, monotonic
from ppaas.errors import QuotaExceeded

WINDOW = 60.0
"""Seconds: a whole quota may be asked for at once, and after that as much as time gives back."""

MAX_KNOWN = 4096
"""Users of whom something is noted, before those whose quota is whole again are forgotten."""


class PlanRate:
    """Counts what is asked for, by the generic cell rate algorithm: a token bucket that is one number a user.

    The number is when all of the user's quota is there again. What is asked for moves it on by its share of the
    window; where that is more than a window ahead, it is refused and moves nothing. See ITU-T I.371, annex A.

    Parameters
    ----------
    quotas : Quotas
        What each user may have.
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, quotas: Quotas, clock: Clock = monotonic) -> None:
        self._quotas = quotas
        self._clock = clock
        self._whole: dict[str, float] = {}

    def take(self, user: str, plans: int = 1) -> None:
        """Count paths that a user asks for.

        Raises
        ------
        QuotaExceeded
            They are too many; it says when they may be asked for, if ever.
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

    def used(self, user: str) -> int:
        """Return how many of a user's paths count now."""
        now = self._clock()
        seconds = max(self._whole.get(user, now) - now, 0.0)
        return math.ceil(round(seconds * self._quotas.of(user).plans_per_minute / WINDOW, 6))


def _too_many(user: str, limit: int, used: int, plans: int, retry: float | None) -> str:
    text = f"user {user!r} may ask for {limit} paths a minute, of which {used} are used; {plans} more cannot be given: "
    if retry is None:
        return f"{text}ask for less at once, or let an administrator raise the quota 'plans_per_minute'"
    return f"{text}ask again in {retry:.3g} s, or let an administrator raise the quota 'plans_per_minute'"
