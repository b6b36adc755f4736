"""Records of sharing: roles on robots, what a robot is shared for with whom, scopes of tokens, identities of users."""

from typing import Literal, get_args

import msgspec

from storage.names import check_name, is_name

ShareRole = Literal["look", "drive", "administer"]
"""Roles of users with whom a robot is shared; each includes those before it."""

TokenRole = Literal["look", "drive", "administer", "robot"]
"""Roles of scoped tokens. ``robot`` connects as the robot itself."""

# Each role includes those before: more would be combinations that nobody remembers (ADR 0045).
SHARE_ROLES: tuple[ShareRole, ...] = get_args(ShareRole)

GROUP = "group:"
"""Prefix of a group among those with whom a robot is shared; no user has it, as names have no colon."""

ALL: tuple[str, ...] = ("*",)
"""Globs of all names."""


class Share(msgspec.Struct, frozen=True):
    """What a robot is shared for with a user or a group.

    Parameters
    ----------
    to : str
        Id of a user, or ``group:`` and the name of a group.
    role : str
        What they may do.
    publish : tuple of str
        Globs of the topics that they may publish, of the services that they may call, and of the actions that they may
        send goals to.
    subscribe : tuple of str
        Globs of the topics that they may subscribe to, and of the services that only read.
    """

    to: str
    role: ShareRole
    publish: tuple[str, ...] = ()
    subscribe: tuple[str, ...] = ALL


class TokenScope(msgspec.Struct, frozen=True):
    """Limit of the rights of a token; it never has more rights than its user.

    Parameters
    ----------
    robots : tuple of str
        Globs of robots of its user, or ``OWNER:ROBOT`` with two globs for robots of others.
    role, publish, subscribe
        As of `Share`.
    """

    robots: tuple[str, ...]
    role: TokenRole
    publish: tuple[str, ...] = ()
    subscribe: tuple[str, ...] = ALL


def is_grantee(text: str) -> bool:
    """Return whether a text is the id of a user, or ``group:`` and the name of a group."""
    return is_name(text.removeprefix(GROUP))


def check_grantee(text: str) -> str:
    """Return a user or a group with whom a robot may be shared.

    Raises
    ------
    InvalidInput
        It is neither the id of a user nor ``group:`` and the name of a group.
    """
    check_name("group" if text.startswith(GROUP) else "user", text.removeprefix(GROUP))
    return text


def grantees_of(user: str, groups: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names under which robots are shared with a user: the id, and the user's groups."""
    return user, *(GROUP + group for group in groups)


class ProvidedIdentity(msgspec.Struct, frozen=True):
    """Somebody for whom an identity provider vouches: its URL, and the subject, which is nobody else's ever there."""

    issuer: str
    subject: str
