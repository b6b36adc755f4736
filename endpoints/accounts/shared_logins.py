"""Logins that all endpoints of a cloud share: throttles, tickets, tokens that are not stored, and changes of users."""

import logging
import threading
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Protocol

from starlette.concurrency import run_in_threadpool

from endpoints.accounts.fair_queue import LoginKind, RequestOrigin
from endpoints.accounts.socket_tickets import SocketTickets
from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, monotonic
from ppaas.errors import TooManyAttempts
from ppaas.listener_faults import ListenerFaults
from storage.disk_space import RefusedTokenFile
from storage.records import Token

logger = logging.getLogger(__name__)


# Throttle of logins: after failures, the next attempt has to wait.
#
# Failures are counted for a user at an address, for a user at all addresses, and for an address with all users. Beyond
# a number of failures each doubles the wait, up to a limit, so that nobody guesses more than a few passwords an hour
# (NIST SP 800-63B-4, section 3.2.2; OWASP ASVS 5.0, 6.3.1). Attempts during the wait are refused without a check of the
# password, and do not extend it.
#
# The owner of an account is not locked out: a user who has logged in from an address before is delayed by the failures
# of this user at this address only.

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

    def admit(self, user: str, address: str) -> RequestOrigin:
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
        return RequestOrigin(user, address, known)

    def failed(self, origin: RequestOrigin) -> int:
        """Count a failed attempt; return the number of failures of this user at this address."""
        now = self._clock()
        self._of_user.add(origin.user, now)
        self._of_address.add(origin.address, now)
        return self._of_pair.add((origin.user, origin.address), now)

    def succeeded(self, origin: RequestOrigin) -> None:
        """Note that a user has logged in from an address."""
        pair = origin.user, origin.address
        self._of_pair.clear(pair)
        self._known[pair] = None


# Tokens that could not be stored wait in memory, so that an administrator can log in and make room.

UNSAVED_LIFETIME = 900.0
"""Lifetime of a token that is not stored [s]."""

MAX_UNSAVED = 256
"""Largest number of such tokens; of more, the oldest are forgotten."""


class UnsavedTokens:
    """Tokens that are in the memory of one process alone. Thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._tokens: BoundedDict[str, Token] = BoundedDict(MAX_UNSAVED)

    def add(self, token: Token) -> None:
        """Keep a token until it expires, is removed, or many newer ones were added."""
        with self._lock:
            self._tokens[token.hash] = token

    def find(self, token_hash: str) -> Token | None:
        """Return a token, expired or not; None if it is not one of these."""
        return self._tokens.get(token_hash)

    def remove(self, token_hash: str) -> bool:
        """Remove a token; return whether it was one of these."""
        with self._lock:
            return self._tokens.pop(token_hash, None) is not None

    def remove_all(self, user: str, *, keep: str | None = None) -> None:
        """Remove the tokens of a user, except one."""
        with self._lock:
            for token in list(self._tokens.values()):
                if token.user == user and token.hash != keep:
                    del self._tokens[token.hash]


MOST_REFUSED = 65_536
"""Largest number of revoked tokens that wait to be removed from the store."""

MOST_REMOVED = 4096
"""Number of the last tokens that were removed from the store after they had been refused. They stay refused, since an
endpoint may have read them before."""


class SharedLogins(Protocol):
    """Logins of all endpoints of a cloud.

    All arguments, results and errors can be sent between processes: texts are valid Unicode. Every method raises
    ``Unavailable`` if the process that keeps the logins cannot be reached.
    """

    async def admit(self, user: str, address: str, kind: LoginKind = "password") -> RequestOrigin:
        """Return the origin of an attempt to log in; raises ``TooManyAttempts`` as ``LoginThrottle.admit`` does.

        Attempts of each kind are counted on their own.
        """
        ...

    async def failed(self, origin: RequestOrigin) -> int:
        """Count a failed attempt; return the number of failures of this user at this address."""
        ...

    async def succeeded(self, origin: RequestOrigin) -> None:
        """Note that a user has logged in from an address."""
        ...

    async def issue_ticket(self, user: str, token_hash: str) -> str:
        """Return a new ticket for a token of a user, given by its id."""
        ...

    async def redeem_ticket(self, ticket: str) -> str:
        """Return the id of the token that a ticket stands for; raises as ``SocketTickets.redeem`` does."""
        ...

    async def forget(self, user: str) -> None:
        """Make all endpoints drop what they remember of a user, whose account or tokens were changed in the store."""
        ...

    async def keep_token(self, token: Token) -> None:
        """Keep a token that cannot be stored."""
        ...

    async def kept_token(self, token_hash: str) -> Token | None:
        """Return a token that is kept, expired or not; None if it is not one of these."""
        ...

    async def drop_token(self, token_hash: str) -> bool:
        """Drop a token that is kept; return whether it was one of these."""
        ...

    async def drop_tokens(self, user: str, keep: str | None) -> None:
        """Drop the tokens of a user that are kept, except the one with the hash ``keep``."""
        ...

    async def refuse_token(self, user: str, token_hash: str) -> None:
        """Refuse a token of a user that was revoked and cannot be removed from the store yet.

        Raises
        ------
        Unavailable
            It is refused, but only until the process ends that keeps the logins.
        """
        ...

    async def is_refused(self, user: str, token_hash: str) -> bool:
        """Return whether a token of a user is refused."""
        ...

    async def removed_token(self, user: str, token_hash: str) -> None:
        """Note that a refused token was removed from the store: it no longer has to be kept for a restart."""
        ...


class LocalLogins:
    """Logins in the memory of this process, which is the only endpoint, or keeps them for all endpoints.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    file : RefusedTokenFile, optional
        Keeps refused tokens on the disk, opened; without it they are refused until this process ends.
    """

    def __init__(self, clock: Clock = monotonic, file: RefusedTokenFile | None = None) -> None:
        self._file = file
        # One throttle a kind: in a common one, a success with a hash that was read on the network would clear the
        # failures of somebody who guesses the user's own password from the same address (ADR 0044).
        self._throttles: dict[LoginKind, LoginThrottle] = {
            "password": LoginThrottle(clock),
            "rapyuta": LoginThrottle(clock),
        }
        self._tickets = SocketTickets(clock)
        self._unsaved = UnsavedTokens()
        self._refused: BoundedDict[tuple[str, str], None] = BoundedDict(MOST_REFUSED)
        self._removed: BoundedDict[tuple[str, str], None] = BoundedDict(MOST_REMOVED)
        self._listeners: list[Callable[[str], None]] = []
        self._faults = ListenerFaults(logger)

    def on_forget(self, listener: Callable[[str], None]) -> None:
        """Call a function with the id of each user who is changed; it must not block."""
        self._listeners.append(listener)

    async def admit(self, user: str, address: str, kind: LoginKind = "password") -> RequestOrigin:
        """Return the origin of an attempt to log in."""
        return self._throttles[kind].admit(user, address)._replace(kind=kind)

    async def failed(self, origin: RequestOrigin) -> int:
        """Count a failed attempt; return the number of failures of this user at this address."""
        return self._throttles[origin.kind].failed(origin)

    async def succeeded(self, origin: RequestOrigin) -> None:
        """Note that a user has logged in from an address."""
        self._throttles[origin.kind].succeeded(origin)

    async def issue_ticket(self, user: str, token_hash: str) -> str:
        """Return a new ticket for a token of a user, given by its id."""
        return self._tickets.issue(user, token_hash)

    async def redeem_ticket(self, ticket: str) -> str:
        """Return the id of the token that a ticket stands for; the ticket is used up."""
        return self._tickets.redeem(ticket)

    async def forget(self, user: str) -> None:
        """Call all listeners."""
        for listener in self._listeners:
            self._faults.call("a listener to changes of users", listener, user)

    async def keep_token(self, token: Token) -> None:
        """Keep a token that cannot be stored."""
        self._unsaved.add(token)

    async def kept_token(self, token_hash: str) -> Token | None:
        """Return a token that is kept, expired or not; None if it is not one of these."""
        return self._unsaved.find(token_hash)

    async def drop_token(self, token_hash: str) -> bool:
        """Drop a token that is kept; return whether it was one of these."""
        return self._unsaved.remove(token_hash)

    async def drop_tokens(self, user: str, keep: str | None) -> None:
        """Drop the tokens of a user that are kept, except one."""
        self._unsaved.remove_all(user, keep=keep)

    async def refuse_token(self, user: str, token_hash: str) -> None:
        """Refuse a token of a user that cannot be removed from the store yet."""
        self._refused[user, token_hash] = None
        if self._file is not None:
            await run_in_threadpool(self._file.add, user, token_hash)

    async def is_refused(self, user: str, token_hash: str) -> bool:
        """Return whether a token of a user is refused."""
        return (user, token_hash) in self._refused or (user, token_hash) in self._removed

    async def removed_token(self, user: str, token_hash: str) -> None:
        """Note that a refused token was removed from the store."""
        self._removed[user, token_hash] = None
        self._refused.pop((user, token_hash), None)
        if self._file is not None:
            await run_in_threadpool(self._file.remove, user, token_hash)
