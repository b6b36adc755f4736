"""User of a scoped token."""

import msgspec

from storage.records import Token, User
from storage.sharing_records import TokenScope


class ScopedUser(User, frozen=True, kw_only=True):
    """User whose request was authenticated by a scoped token: an ordinary user, also if the user is an administrator.

    ``scope`` is the token's scope. The password hash is empty.
    """

    scope: TokenScope


def user_of_token(user: User, token: Token) -> User:
    """Return the caller who sent a token: a `ScopedUser` if the token has a scope."""
    if token.scope is None:
        return user
    fields = msgspec.structs.asdict(user) | {"role": "user", "password_hash": ""}
    return ScopedUser(**fields, scope=token.scope)
