"""The person whom a token of an identity provider is about: identity, name and role."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from endpoints.oidc.settings import OidcSettings, ProvidedRole
from ppaas.errors import NotAuthenticated, NotPermitted
from storage.names import is_name
from storage.sharing_records import ProvidedIdentity

MAX_NAME = 64

_UNFIT = re.compile(r"[^A-Za-z0-9_.-]+")
"""Characters that names of users do not have."""


@dataclass(frozen=True, slots=True)
class ProvidedPerson:
    """ProvidedPerson, or program, whom the provider vouches for.

    Parameters
    ----------
    identity : ProvidedIdentity
        Who it is: it never changes, and is never given to somebody else.
    name : str
        Name of a new user for it. It may change, and others may have it later: it identifies nobody.
    role : str
    """

    identity: ProvidedIdentity
    name: str
    role: ProvidedRole


def person_of(claims: Mapping[str, Any], settings: OidcSettings, *, is_program: bool = False) -> ProvidedPerson:
    """Return the person of a token that was checked.

    Parameters
    ----------
    claims : mapping
        What the token says.
    settings : OidcSettings
    is_program : bool
        Whether the token may lack a name: the id of its client takes the place.

    Raises
    ------
    NotPermitted
        The person is in no group that has a role.
    NotAuthenticated
        The token has no name that a user can have, or an e-mail address that is not verified.
    """
    role = settings.role_of(groups_of(claims, settings.groups_claim))
    if role is None:
        raise NotPermitted(
            f"{settings.shown_name} knows you, but none of your groups may use this cloud: ask its operator "
            "(--oidc-role)"
        )
    return ProvidedPerson(
        ProvidedIdentity(claims["iss"], claims["sub"]), _name_of(claims, settings, is_program=is_program), role
    )


def groups_of(claims: Mapping[str, Any], name: str) -> frozenset[str]:
    """Return the groups in a claim; empty if it has none."""
    found = claim_of(claims, name)
    listed = found if isinstance(found, list) else [found]
    return frozenset(each for each in listed if isinstance(each, str))


def claim_of(claims: Mapping[str, Any], name: str) -> Any:
    """Return the claim of a name, or the one at a path such as ``realm_access.roles``; None if there is none."""
    if name in claims:
        return claims[name]
    found: Any = claims
    for part in name.split("."):
        if not isinstance(found, Mapping) or part not in found:
            return None
        found = found[part]
    return found


def _name_of(claims: Mapping[str, Any], settings: OidcSettings, *, is_program: bool) -> str:
    given = claim_of(claims, settings.username_claim)
    if settings.username_claim == "email" and claims.get("email_verified") is not True:
        raise NotAuthenticated("the identity provider has not verified your e-mail address: verify it there first")
    if not given and is_program:
        given = claims.get("client_id") or claims.get("azp")
    name = _UNFIT.sub("-", given).lstrip("-._")[:MAX_NAME] if isinstance(given, str) else ""
    if not is_name(name):
        raise NotAuthenticated(
            f"the token of the identity provider has no name for you in its claim {settings.username_claim!r} "
            "(--oidc-username-claim)"
        )
    return name
