"""Checks of the tokens of an identity provider: signature, issuer, audience, times, and the login that they are for."""

import math
from collections.abc import Collection, Mapping
from typing import Any

from joserfc import jwt
from joserfc.errors import InvalidKeyIdError, JoseError
from joserfc.jwk import KeySet
from joserfc.jwt import JWTClaimsRegistry

from endpoints.oidc.settings import OidcSettings
from ppaas.errors import NotAuthenticated

Claims = Mapping[str, Any]

MAX_TOKEN = 15_000
"""Largest token [characters]."""

MAX_SUBJECT = 255
"""Longest subject (OpenID Connect Core 1.0, 2) [characters]."""

TYPES_OF_IDS = frozenset({"jwt", ""})
TYPES_OF_ACCESS = frozenset({"jwt", "", "at+jwt", "application/at+jwt"})
TYPES_OF_LOGOUT = frozenset({"jwt", "", "logout+jwt", "application/logout+jwt"})
"""Types in the header, in lower case: of tokens that say who somebody is, access tokens (RFC 9068), and logouts."""

LOGOUT = "http://schemas.openid.net/event/backchannel-logout"
"""Event of a logout (OpenID Connect Back-Channel Logout 1.0, 2.4)."""


class UnknownKey(NotAuthenticated):
    """The key of a token is none of the provider's known ones: it may be a new one."""


def signed_claims(token: str, keys: KeySet, algorithms: Collection[str], types: Collection[str]) -> Claims:
    """Return what a token says, once its signature is verified; nothing that it says is checked.

    Raises
    ------
    UnknownKey
        No key has the id that it names.
    NotAuthenticated
        It is no token of this kind, or its signature or its algorithm is wrong.
    """
    if len(token) > MAX_TOKEN:
        raise _refusal(f"it has more than {MAX_TOKEN} characters")
    try:
        found = jwt.decode(token, keys, algorithms=list(algorithms))
    except InvalidKeyIdError as error:
        raise UnknownKey("the token of the identity provider is signed by a key that it does not publish") from error
    except (JoseError, ValueError, TypeError, KeyError) as error:
        raise _refusal(str(error) or type(error).__name__) from error
    if str(found.header.get("typ", "")).lower() not in types:
        raise _refusal(f"its type is {found.header.get('typ')!a}")
    return found.claims


def check_id_token(claims: Claims, settings: OidcSettings, now: float, nonce: str | None) -> None:
    """Check a token that says who somebody is (OpenID Connect Core 1.0, 3.1.3.7).

    Parameters
    ----------
    claims : mapping
    settings : OidcSettings
    now : float
        Time [s since the epoch].
    nonce : str, optional
        Nonce of the login that it is for; None if the login has none.

    Raises
    ------
    NotAuthenticated
        It is of another issuer, for another client or another login, expired, or not valid yet.
    """
    _check(claims, settings, now, settings.client_id, ("iat",))
    party = claims.get("azp")
    if party is None and isinstance(claims["aud"], list) and len(claims["aud"]) > 1:
        raise _refusal("it is for several clients and names none of them as its party (azp)")
    if party not in (None, settings.client_id):
        raise _refusal("it is for another client (azp)")
    if nonce is not None and claims.get("nonce") != nonce:
        raise _refusal("it is for another login (nonce)")


def check_access_token(claims: Claims, settings: OidcSettings, now: float) -> None:
    """Check an access token for this cloud; raises as `check_id_token`."""
    _check(claims, settings, now, settings.audience, ())


def check_logout_token(claims: Claims, settings: OidcSettings, now: float) -> None:
    """Check a token by which the provider reports a logout (OpenID Connect Back-Channel Logout 1.0, 2.6).

    Raises
    ------
    NotAuthenticated
        It is of another issuer, for another client, expired, of no logout or of nobody, or says who somebody is.
    """
    if "nonce" in claims:
        raise _refusal("it has a nonce: it says who somebody is, and reports no logout")
    if "sub" not in claims and "sid" not in claims:
        raise _refusal("it names neither a person (sub) nor a session (sid)")
    _check(claims, settings, now, settings.client_id, ("iat", "jti", "events"), with_subject="sub" in claims)
    events = claims["events"]
    if not isinstance(events, dict) or not isinstance(events.get(LOGOUT), dict):
        raise _refusal("it is of another event than a logout (events)")
    for name in ("sid", "jti"):
        if name in claims and not is_session(claims[name]):
            raise _refusal(f"its {name} is empty, no text or too long")


def is_session(value: object) -> bool:
    """Return whether a value is the name of a session."""
    return isinstance(value, str) and 0 < len(value) <= MAX_SUBJECT and value.isprintable()


def _check(
    claims: Claims,
    settings: OidcSettings,
    now: float,
    audience: str,
    needed: Collection[str],
    *,
    with_subject: bool = True,
) -> None:
    wanted: dict[str, Any] = {
        "iss": {"essential": True, "value": settings.issuer},
        "aud": {"essential": True, "value": audience},
        "exp": {"essential": True},
        **{name: {"essential": True} for name in (*needed, *(("sub",) if with_subject else ()))},
    }
    try:
        JWTClaimsRegistry(now=int(now), leeway=math.ceil(settings.leeway), **wanted).validate(dict(claims))
    except JoseError as error:
        raise _refusal(str(error)) from error
    if with_subject and (len(claims["sub"]) > MAX_SUBJECT or not claims["sub"].isprintable()):
        raise _refusal(f"its sub has more than {MAX_SUBJECT} characters, or some that cannot be printed")


def _refusal(why: str) -> NotAuthenticated:
    return NotAuthenticated(f"the token of the identity provider is refused: {why}")
