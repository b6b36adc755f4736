"""Tickets for WebSockets: each stands for a token, in one handshake.

Browsers cannot send headers in the handshake of a WebSocket, and addresses are written to logs. So a page gets a ticket
by REST, where it sends its token in a header, and puts the ticket into the address instead of the token.
"""

import secrets
from collections import OrderedDict
from dataclasses import dataclass

from ppaas.clock import Clock, monotonic
from ppaas.errors import NotAuthenticated

LIFETIME = 30.0
"""Time for which a ticket can be used [s]."""

MAX_OF_USER = 1000
"""Largest number of unused tickets of a user; the oldest are dropped first. A page needs one for each robot."""

TICKET_PREFIX = "ppaas_once_"
"""Prefix of tickets."""


@dataclass(frozen=True, slots=True)
class _Issued:
    token_hash: str
    until: float


class SocketTickets:
    """Unused tickets, in memory: no other cloud takes them.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._of_users: dict[str, OrderedDict[str, _Issued]] = {}
        self._owners: dict[str, str] = {}

    def __len__(self) -> int:
        """Return the number of tickets that are kept."""
        return len(self._owners)

    def issue(self, user: str, token_hash: str) -> str:
        """Return a new ticket for a token of a user, given by its id."""
        self._drop_expired()
        ticket = TICKET_PREFIX + secrets.token_urlsafe(24)
        issued = self._of_users.setdefault(user, OrderedDict())
        if len(issued) >= MAX_OF_USER:
            del self._owners[issued.popitem(last=False)[0]]
        issued[ticket] = _Issued(token_hash, self._clock() + LIFETIME)
        self._owners[ticket] = user
        return ticket

    def redeem(self, ticket: str) -> str:
        """Return the id of the token that a ticket stands for; the ticket is used up.

        Raises
        ------
        NotAuthenticated
            The ticket is unknown, was used, or has expired.
        """
        owner = self._owners.pop(ticket, None)
        found = None if owner is None else self._remove(owner, ticket)
        if found is None or found.until <= self._clock():
            raise NotAuthenticated(
                f"the ticket is unknown, was used before, or is older than {LIFETIME:g} s: get another with "
                "POST /v1/tickets for each connection"
            )
        return found.token_hash

    def _remove(self, user: str, ticket: str) -> _Issued:
        issued = self._of_users[user]
        found = issued.pop(ticket)
        if not issued:
            del self._of_users[user]
        return found

    def _drop_expired(self) -> None:
        now = self._clock()
        while self._owners:  # the oldest first, as both tables keep the order of issue
            ticket, user = next(iter(self._owners.items()))
            if self._of_users[user][ticket].until > now:
                return
            del self._owners[ticket]
            self._remove(user, ticket)
