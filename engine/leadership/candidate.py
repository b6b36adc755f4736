"""Candidate for a lease, without I/O: answers of the store in, requests to the store out, and time as an argument.

No clock is compared with another. A standby measures by its own clock for how long it has seen no change of a lease,
and the leader measures by its own clock since it began to ask for its last renewal. The leader stops before a standby
may begin: the renewal was stored after the leader asked for it, and the standby saw it after it was stored.
"""

import enum
import math
from dataclasses import dataclass

from storage.records import Lease


@dataclass(frozen=True, slots=True)
class LeaseTiming:
    """Periods of candidates, the same for all of a lease [s].

    Parameters
    ----------
    renew : float
        Time between two renewals by the leader.
    look : float
        Time between two looks of a standby, and before a failed request is repeated.
    validity : float
        Time for which a leader leads after it began to ask for a renewal that was stored.
    patience : float
        Time without a change after which a standby takes over. Longer than ``validity`` by more than clocks of two
        hosts can differ over that time.
    """

    renew: float = 0.5
    look: float = 0.25
    validity: float = 2.5
    patience: float = 3.0


class Role(enum.Enum):
    """Role of a candidate."""

    WAITING = "waiting"
    LEADING = "leading"
    REPLACED = "replaced"
    """Another process took the lease: this one never leads again."""
    RELEASED = "released"


@dataclass(frozen=True, slots=True)
class Read:
    """Request to read the lease."""

    name: str


@dataclass(frozen=True, slots=True)
class Change:
    """Request to store a lease in place of another."""

    lease: Lease
    instead_of: Lease


Request = Read | Change


class LeaseCandidate:
    """Candidate for a lease. It asks for one thing at a time: after ``next``, one of the answers must follow.

    Parameters
    ----------
    name : str
        Name of the lease.
    holder : str
        Name of this candidate. No two processes that run at once have the same, so a lease of this name was left by an
        earlier process, and is taken without patience.
    now : float
        Time of this process [s], as in all methods.
    timing : LeaseTiming
        Periods.

    Attributes
    ----------
    role : Role
        Current role. A leader may lead no more for a while (``leads``) without being replaced.
    held : Lease
        The lease as this candidate last held it.
    former : str
        The holder from which it was taken; empty if nobody held it, or an earlier process of the same name did.
    rival : str
        Another holder that was seen to renew the lease; empty if there is none.
    due : float
        Time of the next request, unless one is under way.
    """

    def __init__(self, name: str, holder: str, now: float, timing: LeaseTiming) -> None:
        self.role = Role.WAITING
        self.held = Lease(name)
        self.former = self.rival = ""
        self.due = now
        self._holder = holder
        self._timing = timing
        self._under_way: tuple[Request, float] | None = None
        self._seen: Lease | None = None
        self._since = now
        self._unsure = True
        self._until = -math.inf

    @property
    def is_over(self) -> bool:
        """Whether this candidate never leads again."""
        return self.role in (Role.REPLACED, Role.RELEASED)

    def leads(self, now: float) -> bool:
        """Return whether this candidate leads: no other one can have taken the lease yet."""
        return self.role is Role.LEADING and now < self._until

    def next(self, now: float) -> Request | None:
        """Return the request that is due, or None."""
        if self._under_way is not None or self.is_over or now < self.due:
            return None
        request = self._renewal() if self.role is Role.LEADING else self._attempt(now)
        self._under_way = request, now
        return request

    def _renewal(self) -> Request:
        # A change whose answer was lost may have been stored, or be stored later.
        return Read(self.held.name) if self._unsure else Change(self._next_beat(self._holder), self.held)

    def _attempt(self, now: float) -> Request:
        seen = self._seen
        if self._unsure or seen is None or not self._may_take(seen, now):
            return Read(self.held.name)
        return Change(Lease(seen.name, self._holder, seen.epoch + 1), seen)

    def _may_take(self, seen: Lease, now: float) -> bool:
        return seen.holder in ("", self._holder) or now - self._since >= self._timing.patience

    def _next_beat(self, holder: str) -> Lease:
        return Lease(self.held.name, holder, self.held.epoch, self.held.beat + 1)

    # -- answers -------------------------------------------------------------------------------------------------------

    def was_read(self, lease: Lease, now: float) -> None:
        """Take the answer of a ``Read``."""
        self._under_way, self._unsure, self.due = None, False, now
        if self.role is Role.WAITING:
            self._look(lease, now)
        elif lease == self._next_beat(self._holder):
            self.held = lease  # a renewal whose answer was lost
        elif lease != self.held:
            self._replaced()

    def _look(self, lease: Lease, now: float) -> None:
        if lease != self._seen:
            if self._seen is not None and lease.holder not in ("", self._holder):
                self.rival = lease.holder
            self._seen, self._since = lease, now
        if not self._may_take(lease, now):
            self.due = min(now + self._timing.look, self._since + self._timing.patience)
            self._unsure = now + self._timing.look < self._since + self._timing.patience

    def was_changed(self, now: float, *, done: bool) -> None:
        """Take the answer of a ``Change``: whether it was stored."""
        under_way, self._under_way = self._under_way, None
        request, asked = under_way or (None, now)
        if not isinstance(request, Change):
            raise ValueError("no change of the lease is under way")
        if self.is_over:
            return
        if not done:
            self._unsure, self.due = True, now
            return
        if self.role is Role.WAITING:
            self.former = "" if request.instead_of.holder == self._holder else request.instead_of.holder
        self.role, self.held, self._unsure = Role.LEADING, request.lease, False
        # From the time of the request: no other candidate can have seen this beat, and counted its patience, before.
        self._until, self.due = asked + self._timing.validity, asked + self._timing.renew

    def has_failed(self, now: float) -> None:
        """Take an error in place of an answer: a change may have been stored all the same, or be stored later."""
        self._under_way, self._unsure, self.due = None, True, now + self._timing.look

    def heard_of(self, epoch: int) -> None:
        """Take note of an epoch that somebody follows: if it is a later one, this leader was replaced."""
        if self.role is Role.LEADING and epoch > self.held.epoch:
            self._replaced()

    def release(self) -> Change | None:
        """Lead no more, while nothing is under way; return the request that lets another candidate lead at once."""
        if self.role is not Role.LEADING or self._under_way is not None:
            return None
        self.role = Role.RELEASED
        return Change(self._next_beat(""), self.held)

    def _replaced(self) -> None:
        self.role, self._until = Role.REPLACED, -math.inf
