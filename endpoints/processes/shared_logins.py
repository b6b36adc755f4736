"""Logins that the master keeps for all endpoints, as an endpoint calls them."""

from endpoints.accounts.fair_queue import LoginKind, Origin
from endpoints.accounts.shared_logins import SharedLogins
from engine.endpoint.master_link import MasterLink
from storage.records import Token


class MasterLogins:
    """Logins of the master; implements ``SharedLogins``.

    Parameters
    ----------
    master : MasterLink
    """

    def __init__(self, master: MasterLink) -> None:
        self._master = master

    async def admit(self, user: str, address: str, kind: LoginKind = "password") -> Origin:
        """Return the origin of an attempt to log in."""
        return await self._master.call(SharedLogins.admit, user, address, kind)

    async def failed(self, origin: Origin) -> int:
        """Count a failed attempt; return the number of failures of this user at this address."""
        return await self._master.call(SharedLogins.failed, origin)

    async def succeeded(self, origin: Origin) -> None:
        """Note that a user has logged in from an address."""
        await self._master.call(SharedLogins.succeeded, origin)

    async def issue_ticket(self, user: str, token_hash: str) -> str:
        """Return a new ticket for a token of a user, given by its id."""
        return await self._master.call(SharedLogins.issue_ticket, user, token_hash)

    async def redeem_ticket(self, ticket: str) -> str:
        """Return the id of the token that a ticket stands for; the ticket is used up."""
        return await self._master.call(SharedLogins.redeem_ticket, ticket)

    async def forget(self, user: str) -> None:
        """Make all endpoints drop what they remember of a user."""
        await self._master.call(SharedLogins.forget, user)

    async def keep_token(self, token: Token) -> None:
        """Keep a token that cannot be stored."""
        await self._master.call(SharedLogins.keep_token, token)

    async def kept_token(self, token_hash: str) -> Token | None:
        """Return a token that is kept, expired or not; None if it is not one of these."""
        return await self._master.call(SharedLogins.kept_token, token_hash)

    async def drop_token(self, token_hash: str) -> bool:
        """Drop a token that is kept; return whether it was one of these."""
        return await self._master.call(SharedLogins.drop_token, token_hash)

    async def drop_tokens(self, user: str, keep: str | None) -> None:
        """Drop the tokens of a user that are kept, except one."""
        await self._master.call(SharedLogins.drop_tokens, user, keep)

    async def refuse_token(self, user: str, token_hash: str) -> None:
        """Refuse a token of a user that cannot be removed from the store yet."""
        await self._master.call(SharedLogins.refuse_token, user, token_hash)

    async def is_refused(self, user: str, token_hash: str) -> bool:
        """Return whether a token of a user is refused."""
        return await self._master.call(SharedLogins.is_refused, user, token_hash)

    async def removed_token(self, user: str, token_hash: str) -> None:
        """Forget a refused token, because it was removed from the store."""
        await self._master.call(SharedLogins.removed_token, user, token_hash)
