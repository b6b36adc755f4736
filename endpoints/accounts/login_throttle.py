"""Throttle of logins: after failures, the next attempt has to wait.

Failures are counted for a user at an address, for a user at all addresses, and for an address with all users. Beyond a
number of failures each doubles the wait, up to a limit, so that nobody guesses more than a few passwords an hour (NIST
SP 800-63B-4, section 3.2.2; OWASP ASVS 5.0, 6.3.1). Attempts during the wait are refused without a check of the
password, and do not extend it.

The owner of an account is not locked out: a user who has logged in from an address before is delayed by the failures of
this user at this address only.
"""

from collections.abc import Hashable
from dataclasses import dataclass

from endpoints.accounts.fair_queue import Origin
from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, monotonic
from ppaas.errors import TooManyAttempts

FORGET = 900.0
"""Time after the last failure at which failures are forgotten [s]."""

MAX_COUNTED = 10_000
"""Largest number of counters of each kind, and of known addresses of users; the oldest are evicted first."""


@dataclass(frozen=True, slots=True)
class Allowance:
    """Failures without a wait, first wait, and longest wait [s]."""

    failures: int
    first: float
    longest: float


USER_AT_ADDRESS = Allowance(10, 1.0, 60.0)
USER = Allowance(50, 1.0, 60.0)
ADDRESS = Allowance(100, 0.5, 30.0)


class FailureCounter:
    """Failures by key, and the waits that follow from them.

    Parameters
    ----------
    allowance : Allowance
        Failures without a wait, and waits.
    """

    def __init__(self, allowance: Allowance) -> None:
        self._allowance = allowance
        self._failures: BoundedDict[Hashable, tuple[int, float]] = BoundedDict(MAX_COUNTED)

    def wait(self, key: Hashable, now: float) -> float:
        """Return the time until the next attempt is allowed [s], at most 0 if it is allowed now."""
        count, last = self._failures.get(key, (0, now))
        excess = count - self._allowance.failures
        if excess < 0 or now - last >= FORGET:
            return 0.0
        return last + min(self._allowance.first * 2.0 ** min(excess, 30), self._allowance.longest) - now

    def add(self, key: Hashable, now: float) -> int:
        """Count a failure; return the number of failures."""
        count, last = self._failures.get(key, (0, now))
        count = 1 if now - last >= FORGET else count + 1
        self._failures[key] = (count, now)
        return count

    def clear(self, key: Hashable) -> None:
        """Forget the failures of a key."""
        self._failures.pop(key, None)


class LoginThrottle:
    """Admits and refuses attempts to log in.

    Parameters
    ----------
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._of_pair = FailureCounter(USER_AT_ADDRESS)
        self._of_user = FailureCounter(USER)
        self._of_address = FailureCounter(ADDRESS)
        self._known: BoundedDict[tuple[str, str], None] = BoundedDict(MAX_COUNTED)

    def admit(self, user: str, address: str) -> Origin:
        """Return the origin of an attempt.

        Raises
        ------
        TooManyAttempts
            After too many failures; ``retry_after`` is the time until the next attempt is allowed [s].
        """
        now, pair = self._clock(), (user, address)
        known = pair in self._known
        wait = self._of_pair.wait(pair, now)
        if not known:
            wait = max(wait, self._of_user.wait(user, now), self._of_address.wait(address, now))
        if wait > 0.0:
            raise TooManyAttempts(f"too many failed logins: try again in {wait:.0f} s", retry_after=wait)
        return Origin(user, address, known)

    def failed(self, origin: Origin) -> int:
        """Count a failed attempt; return the number of failures of this user at this address."""
        now = self._clock()
        self._of_user.add(origin.user, now)
        self._of_address.add(origin.address, now)
        return self._of_pair.add((origin.user, origin.address), now)

    def succeeded(self, origin: Origin) -> None:
        """Note that a user has logged in from an address."""
        pair = origin.user, origin.address
        self._of_pair.clear(pair)
        self._known[pair] = None
