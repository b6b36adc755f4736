"""Accounts: users, their passwords and their tokens."""

import logging
import secrets
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import msgspec
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.fair_queue import RequestOrigin
from endpoints.accounts.identities import Identities
from endpoints.accounts.passwords import Passwords, RapyutaPasswords
from endpoints.accounts.shared_logins import LocalLogins, SharedLogins
from endpoints.accounts.tokens import TOKEN_LIFETIME, IssuedToken, TokenCache, Tokens, received_token_id
from endpoints.accounts.user_lookup import counted_name, find_user
from endpoints.accounts.user_turns import LocalTurns, UserTurns, in_turn
from ppaas.clock import Clock, epoch
from ppaas.errors import Conflict, InvalidInput, NotAuthenticated, NotFound, NotPermitted, Unavailable
from storage.disk_space import RefusedToken
from storage.names import check_name
from storage.ports import UserStore
from storage.records import Role, User
from storage.sharing_records import TokenScope

logger = logging.getLogger(__name__)

ADMIN = "admin"
ME = "me"
"""Alias of the calling user; no user may have this id."""

LEFT = "left:"
"""Prefix of the password hash of a user who is to be removed: no password has it."""

MIN_PASSWORD = 8
MAX_PASSWORD = 1024

Regroup = Callable[[tuple[str, ...]], tuple[str, ...]]
"""Takes the groups of a user, and returns the new ones."""


class Accounts:
    """Registers users, logs them in and authenticates their tokens; of one endpoint.

    Endpoints of one cloud share the store, ``logins`` and ``turns``. When another endpoint has changed a user,
    ``forget_user`` is called.

    Parameters
    ----------
    store : UserStore
        Store of users and tokens.
    clock : callable
        Returns the time [s since the epoch].
    passwords : Passwords, optional
        Password hashing; closed with the accounts.
    lifetime : float
        Lifetime of a token [s].
    cache : TokenCache, optional
        Cache of verified tokens.
    logins : SharedLogins, optional
        Throttles, tickets and tokens that are not stored; by default in this process.
    turns : UserTurns, optional
        Turns in which a user is read and changed; by default of this process.

    Attributes
    ----------
    rapyuta : RapyutaPasswords
        Passwords of users for robots that log in by the protocol of Rapyuta.
    identities : Identities
        Users who log in with an identity provider.
    """

    def __init__(
        self,
        store: UserStore,
        clock: Clock = epoch,
        *,
        passwords: Passwords | None = None,
        lifetime: float = TOKEN_LIFETIME,
        cache: TokenCache | None = None,
        logins: SharedLogins | None = None,
        turns: UserTurns | None = None,
    ) -> None:
        self._store, self._clock = store, clock
        self._passwords = passwords or Passwords()
        self._logins = logins or LocalLogins()
        self._turns = turns or LocalTurns()
        self._tokens = Tokens(store, clock, lifetime=lifetime, cache=cache or TokenCache(), logins=self._logins)
        self.rapyuta = RapyutaPasswords(
            store, self._passwords, tokens=self._tokens, logins=self._logins, turns=self._turns
        )
        self.identities = Identities(store, self._tokens, self._turns, clock)

    async def refuse(self, tokens: Iterable[RefusedToken]) -> None:
        """Refuse tokens that were revoked before a restart of the cloud, and remove them from the store."""
        await self._tokens.refuse(tokens)

    def close(self) -> None:
        """End the threads that hash passwords, and the removal of revoked tokens."""
        self._passwords.close()
        self._tokens.close()

    async def register(self, user_id: str, password: str, role: Role = "user", groups: tuple[str, ...] = ()) -> User:
        """Create a user.

        Raises
        ------
        InvalidInput
            The id is not a valid name, or the password is too short or too long.
        Conflict
            The id is taken.
        Unavailable
            Too many passwords are being hashed.
        """
        if check_name("user", user_id) == ME:
            raise InvalidInput(f"{ME!r} is reserved for the calling user: choose another id")
        _check_password(password)
        user = User(user_id, await self._passwords.hash(password), role, groups=groups, since=self._clock())
        await run_in_threadpool(self._store.add_user, user)
        return user

    async def ensure_admin(self, password: str) -> User:
        """Return the user ``admin``, created with this password if missing; an existing user keeps its password."""
        admin = await find_user(self._store, ADMIN)
        if admin is None:
            try:
                return await self.register(ADMIN, password, "admin")
            except Conflict:  # another endpoint, started at the same time, was first
                admin = await run_in_threadpool(self._store.user, ADMIN)
        if admin.role != "admin":
            raise Conflict(f"user {ADMIN!r} exists but is not an administrator: remove it first")
        return admin

    async def warn_if_different(self, user: User, password: str) -> None:
        """Log a warning if a user has a different password; this takes as long as a login."""
        if not await self._passwords.verify(user.password_hash, password):
            logger.warning("user %r exists with a different password and keeps it", user.id)

    async def sign_in(self, user_id: str, password: str, address: str = "") -> IssuedToken:
        """Return a new token for a user and password.

        Parameters
        ----------
        user_id, password : str
        address : str
            Address of the client, by which attempts are throttled.

        Raises
        ------
        NotAuthenticated
            The user does not exist or the password is wrong; neither text nor response time reveals which.
        TooManyAttempts
            Too many logins of this user or from this address failed.
        Unavailable
            Too many passwords are being hashed.
        """
        origin = await self._logins.admit(counted_name(user_id), address)
        found = await find_user(self._store, user_id)
        user = None if found is None or found.leaving else found
        if not await self._matches(user, password, origin) or user is None:
            raise NotAuthenticated("wrong user or password")
        try:
            return await self._tokens.issue(user.id)
        except NotFound as error:
            raise NotAuthenticated("wrong user or password") from error

    async def issue_scoped(self, user_id: str, scope: TokenScope, lifetime: float, name: str = "") -> IssuedToken:
        """Return a new token of a user for some robots only; ``NotFound`` if the user does not exist.

        Parameters
        ----------
        user_id : str
        scope : TokenScope
            Limit of its rights.
        lifetime : float
            Time after which it expires [s].
        name : str
            What it is for.

        Raises
        ------
        Unavailable
            The store takes nothing now.
        """
        return await self._tokens.issue_scoped(user_id, scope, lifetime, name)

    async def login(self, user_id: str, password: str) -> str:
        """Return the text of a new token; raises as ``sign_in`` does."""
        return (await self.sign_in(user_id, password)).token

    async def authenticate(self, token: str) -> User:
        """Return the user of a token, a `ScopedUser` if it has a scope; ``NotAuthenticated`` if unknown or expired.

        While the store is unreachable, recently verified tokens are accepted.
        """
        return await self.user_of(received_token_id(token))

    async def user_of(self, token_hash: str) -> User:
        """Return the user of a token, given by its id; raises as ``authenticate`` does."""
        return await self._tokens.user_of(token_hash)

    async def issue_ticket(self, user_id: str, token_hash: str) -> str:
        """Return a new ticket of a user, which stands for a token in the handshake of one WebSocket."""
        return await self._logins.issue_ticket(user_id, token_hash)

    async def redeem_ticket(self, ticket: str) -> str:
        """Return the id of the token that a ticket stands for; ``NotAuthenticated`` if it is unknown, used or old."""
        return await self._logins.redeem_ticket(ticket)

    async def change(
        self,
        user_id: str,
        *,
        role: Role | None = None,
        password: str | None = None,
        keep_token: str | None = None,
        limits: Mapping[str, float | None] | None = None,
        regroup: Regroup | None = None,
    ) -> User:
        """Change role, password, limits or groups of a user; a new password revokes all tokens except ``keep_token``.

        Omitted limits stay unchanged; None restores the limit of all users. ``regroup`` is called with the groups of
        the user, and returns the new ones.

        Raises
        ------
        NotFound
            The user does not exist.
        InvalidInput
            The password is too short or too long.
        """
        await run_in_threadpool(self._store.user, user_id)  # raises before the password is hashed in vain
        changes: dict[str, Any] = {} if role is None else {"role": role}
        if password is not None:
            _check_password(password)
            await self.rapyuta.check_other(user_id, password)
            changes["password_hash"] = await self._passwords.hash(password)
        try:
            if password is not None:
                await self._tokens.drop_kept(user_id, keep=keep_token)
            return await in_turn(
                self._turns, user_id, lambda _: self._change(user_id, changes, limits or {}, keep_token, regroup)
            )
        finally:
            await self._tokens.forget(user_id)

    async def check_password(self, user_id: str, password: str, address: str = "") -> None:
        """Raise ``NotPermitted`` unless this is the user's password, ``TooManyAttempts`` as ``sign_in`` does."""
        origin = await self._logins.admit(counted_name(user_id), address)
        if not await self._matches(await run_in_threadpool(self._store.user, user_id), password, origin):
            raise NotPermitted("old_password is not the current password of this user")

    async def _matches(self, user: User | None, password: str, origin: RequestOrigin) -> bool:
        """Return whether the password is right, and count the attempt."""
        if await self._passwords.verify(user.password_hash if user else None, password, origin):
            await self._logins.succeeded(origin)
            return True
        failures = await self._logins.failed(origin)
        logger.warning("login of %.64r from %s failed (%d in a row)", origin.user, origin.address or "here", failures)
        return False

    async def revoke(self, user_id: str, token: str) -> None:
        """Revoke a token of a user by its id; ``NotFound`` if the user has no such token."""
        await self._tokens.revoke(user_id, token)

    async def revoke_all(self, user_id: str) -> None:
        """Revoke all tokens of a user; ``NotFound`` if the user does not exist."""
        await run_in_threadpool(self._store.user, user_id)
        await self._tokens.revoke_all(user_id)

    async def begin_removal(self, user_id: str) -> None:
        """Take all rights from a user who is to be removed, and all tokens; the id stays taken until `remove`.

        Raises
        ------
        NotFound
            The user does not exist.
        """
        left = f"{LEFT}{secrets.token_hex(16)}"
        gone = {"leaving": True, "password_hash": left, "rapyuta_hash": "", "identity": None}
        try:
            await self._tokens.drop_kept(user_id)
            await in_turn(self._turns, user_id, lambda _: self._change(user_id, gone, {}, None, None))
        finally:
            await self._tokens.forget(user_id)

    async def remove(self, user_id: str) -> None:
        """Remove a user with tokens and robots; ``NotFound`` if the user does not exist."""
        try:
            await self._tokens.drop_kept(user_id)
            await in_turn(self._turns, user_id, lambda _: self._store.remove_user(user_id))
            await self._tokens.drop_kept(user_id)  # of logins meanwhile
        finally:
            await self._tokens.forget(user_id)

    def forget_user(self, user_id: str) -> None:
        """Read a user and the user's tokens again, because another endpoint has changed them."""
        self._tokens.forget_user(user_id)

    def forget_all(self) -> None:
        """Read all users again, because another endpoint may have changed them without notice to this one."""
        self._tokens.forget_all()

    async def is_known(self, user_id: str) -> bool:
        """Return whether a user exists; False also if the store is unreachable."""
        try:
            return await find_user(self._store, user_id) is not None
        except Unavailable:
            return False

    def _change(
        self,
        user_id: str,
        changes: dict[str, Any],
        limits: Mapping[str, float | None],
        keep_token: str | None,
        regroup: Regroup | None,
    ) -> User:
        user = self._store.user(user_id)
        own = msgspec.structs.replace(user.limits, **limits)
        groups = user.groups if regroup is None else regroup(user.groups)
        changed = msgspec.structs.replace(user, limits=own, groups=groups, **changes)
        self._store.change_user(changed, keep_token=keep_token)
        return changed


def _check_password(password: str) -> None:
    if not MIN_PASSWORD <= len(password) <= MAX_PASSWORD:
        raise InvalidInput(f"a password must have {MIN_PASSWORD} to {MAX_PASSWORD} characters, not {len(password)}")
