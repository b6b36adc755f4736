"""Logins that all endpoints of a cloud share: throttles, tickets, tokens that are not stored, and changes of users."""

import logging
from collections.abc import Callable
from typing import Protocol

from starlette.concurrency import run_in_threadpool

from endpoints.accounts.fair_queue import LoginKind, Origin
from endpoints.accounts.login_throttle import LoginThrottle
from endpoints.accounts.socket_tickets import SocketTickets
from endpoints.accounts.unsaved_tokens import UnsavedTokens
from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, monotonic
from ppaas.listener_faults import ListenerFaults
from storage.disk_space.refused_tokens import RefusedTokenFile
from storage.records import Token

logger = logging.getLogger(__name__)

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

    async def admit(self, user: str, address: str, kind: LoginKind = "password") -> Origin:
        """Return the origin of an attempt to log in; raises ``TooManyAttempts`` as ``LoginThrottle.admit`` does.

        Attempts of each kind are counted on their own.
        """
        ...

    async def failed(self, origin: Origin) -> int:
        """Count a failed attempt; return the number of failures of this user at this address."""
        ...

    async def succeeded(self, origin: Origin) -> None:
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

    async def admit(self, user: str, address: str, kind: LoginKind = "password") -> Origin:
        """Return the origin of an attempt to log in."""
        return self._throttles[kind].admit(user, address)._replace(kind=kind)

    async def failed(self, origin: Origin) -> int:
        """Count a failed attempt; return the number of failures of this user at this address."""
        return self._throttles[origin.kind].failed(origin)

    async def succeeded(self, origin: Origin) -> None:
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
