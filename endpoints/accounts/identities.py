"""Users for whom an identity provider vouches: found and bound by who they are there, never by their name."""

import logging
import secrets

import msgspec
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.tokens import IssuedToken, Tokens
from endpoints.accounts.user_lookup import find_user
from endpoints.accounts.user_turns import UserTurns, in_turn
from ppaas.clock import Clock
from ppaas.errors import Conflict, NotAuthenticated, NotFound
from storage.migration.copying import one_by_one
from storage.ports import UserStore
from storage.records import Role, Token, User
from storage.sharing_records import ProvidedIdentity

logger = logging.getLogger(__name__)

PROVIDED = "provided:"
"""Prefix of the password hash of a user without a password: no password has it."""

RESERVED = frozenset({"admin", "me"})
"""Names that no identity gets: the administrator who has the password of the cloud, and the alias of the caller."""

PAGE = 500


class Identities:
    """Finds, creates, links and logs in users by their identity at a provider.

    Parameters
    ----------
    store : UserStore
    tokens : Tokens
    turns : UserTurns
    clock : callable
        Returns the time [s since the epoch].
    """

    def __init__(self, store: UserStore, tokens: Tokens, turns: UserTurns, clock: Clock) -> None:
        self._store = store
        self._tokens = tokens
        self._turns = turns
        self._clock = clock

    async def find(self, identity: ProvidedIdentity, name: str) -> User | None:
        """Return the user of an identity; None if there is none, and the name is free for it.

        Parameters
        ----------
        identity : ProvidedIdentity
        name : str
            Name of a new user.

        Raises
        ------
        Conflict
            Another user has the name, or nobody may have it.
        NotAuthenticated
            The user is being removed.
        """
        named = await find_user(self._store, name)
        user = named
        if named is None or named.identity != identity:
            user = await run_in_threadpool(self._user_of, identity)
        if user is not None:
            if user.leaving:
                raise NotAuthenticated("this user is being removed: log in again in a moment")
            return user
        if name in RESERVED or (named is not None and not named.leaving):
            raise Conflict(
                f"user {name!r} exists and is not yours, or the name is reserved: an administrator links it with "
                f"'ppaas user link {name} {identity.subject}', or the identity provider gives you another name"
            )
        return None

    async def create(self, identity: ProvidedIdentity, name: str, role: Role) -> User:
        """Create the user of an identity, without a password; return the one that another login has just created."""
        made = f"{PROVIDED}{secrets.token_hex(16)}"
        user = User(name, made, role, since=self._clock(), identity=identity)
        try:
            await run_in_threadpool(self._store.add_user, user)
        except Conflict:
            found = await self.find(identity, name)
            if found is None:
                raise
            return found
        logger.info("user %r was created for an identity of %s", name, identity.issuer)
        return user

    async def sign_in(self, user: User, role: Role, lifetime: float, session: str = "") -> IssuedToken:
        """Return a new token of a user, who has this role from now on.

        Parameters
        ----------
        user : User
        role : str
        lifetime : float
            Lifetime of the token [s].
        session : str
            Session at the provider; empty if it has no name.

        Raises
        ------
        NotAuthenticated
            The user was removed meanwhile, or belongs to another identity now.
        """

        def settle() -> bool:
            now = self._store.user(user.id)
            if now.identity != user.identity or now.leaving:
                raise NotAuthenticated("this user is no longer yours: log in again")
            if now.role == role:
                return False
            self._store.change_user(msgspec.structs.replace(now, role=role))
            return True

        try:
            if await in_turn(self._turns, user.id, lambda _: settle()):
                await self._tokens.forget(user.id)
                logger.info("user %r has the role %r by the identity provider", user.id, role)
            return await self._tokens.issue(user.id, lifetime, session)
        except NotFound as error:
            raise NotAuthenticated("this user was removed: log in again") from error

    async def sign_out(self, issuer: str, subject: str | None, session: str | None, *, before: float) -> dict[str, int]:
        """Revoke the tokens of logins with a provider; return their number by user.

        Tokens for robots, and tokens of logins with a password, stay.

        Parameters
        ----------
        issuer : str
        subject : str, optional
            Person; without it, the session is sought among all users of the issuer.
        session : str, optional
            Session at the provider; without it, all of the person.
        before : float
            Time until which the logins were [s since the epoch].
        """

        def is_ended(token: Token) -> bool:
            return (
                token.provider_session is not None
                and token.created <= before
                and session in (None, token.provider_session)
            )

        users = await run_in_threadpool(self._users_of, issuer, subject)
        return {user: count for user in users if (count := await self._tokens.revoke_all(user, is_ended))}

    async def link(self, user_id: str, identity: ProvidedIdentity | None) -> User:
        """Bind a user to an identity, which logs in as this user from now on; None ends that, and the user's tokens.

        Raises
        ------
        NotFound
            The user does not exist.
        Conflict
            The identity has another user, or the user is the one who must stay an administrator.
        """
        if user_id in RESERVED and identity is not None:
            raise Conflict(
                f"user {user_id!r} logs in with its password alone: the cloud needs it while there is no IdP"
            )
        if identity is not None:
            other = await run_in_threadpool(self._user_of, identity)
            if other is not None and other.id != user_id:
                raise Conflict(f"this identity belongs to user {other.id!r}: unlink that one first")

        def change() -> User:
            changed = msgspec.structs.replace(self._store.user(user_id), identity=identity)
            self._store.change_user(changed)
            return changed

        try:
            changed = await in_turn(self._turns, user_id, lambda _: change())
            if identity is None:
                await self._tokens.revoke_all(user_id)
            return changed
        finally:
            await self._tokens.forget(user_id)

    def _users_of(self, issuer: str, subject: str | None) -> list[str]:
        if subject is not None:
            user = self._user_of(ProvidedIdentity(issuer, subject))
            return [] if user is None else [user.id]
        users = one_by_one(lambda last: self._store.users(after=last, limit=PAGE), "", lambda user: user.id)
        return [user.id for user in users if user.identity is not None and user.identity.issuer == issuer]

    def _user_of(self, identity: ProvidedIdentity) -> User | None:
        try:
            return self._store.user_with_identity(identity)
        except NotFound:
            return None
