"""Tokens of an identity provider: what is taken, and each lie that is refused."""

import hmac
import json
import math
from collections.abc import Callable
from typing import Any

import pytest
from joserfc import jwt
from joserfc.jwk import KeySet, RSAKey
from joserfc.util import urlsafe_b64encode

from endpoints.oidc.settings import OidcSettings
from endpoints.oidc.tokens import (
    LOGOUT,
    MAX_TOKEN,
    TYPES_OF_ACCESS,
    TYPES_OF_IDS,
    TYPES_OF_LOGOUT,
    UnknownKey,
    check_access_token,
    check_id_token,
    check_logout_token,
    signed_claims,
)
from ppaas.errors import NotAuthenticated
from tests.support.identity.identity_server import IdentityServer, new_key

NOW = 1_800_000_000.0
ISSUER = "https://login.example/realms/lab"
SETTINGS = OidcSettings(
    issuer=ISSUER, client_id="ppaas", cloud_url="https://cloud.example", roles=(("*", "user"),), audience="ppaas-api"
)
GOOD = {"iss": ISSUER, "aud": "ppaas", "sub": "id-of-ann", "iat": NOW, "exp": NOW + 300, "nonce": "n"}
RSA, ELLIPTIC, EDWARDS = (new_key(kind, kind) for kind in ("RS256", "ES256", "Ed25519"))
KEYS = KeySet([RSA, ELLIPTIC, EDWARDS])
signed = IdentityServer.signed


def claims_of(token: str, types: frozenset[str] = TYPES_OF_IDS) -> Any:
    return signed_claims(token, KEYS, SETTINGS.allowed_algorithms, types)


@pytest.mark.parametrize("key", [RSA, ELLIPTIC, EDWARDS], ids=lambda key: key.kid)
def test_a_token_with_a_known_key_is_read(key: Any) -> None:
    assert claims_of(signed(GOOD, key)) == GOOD


def test_a_token_of_an_unknown_key_asks_for_new_keys() -> None:
    with pytest.raises(UnknownKey):
        claims_of(signed(GOOD, new_key("new")))


def test_a_token_of_another_key_with_a_known_id_is_refused() -> None:
    with pytest.raises(NotAuthenticated, match="bad_signature"):
        claims_of(signed(GOOD, new_key("RS256", "RS256")))


def unsigned(header: dict[str, Any]) -> str:
    parts = (urlsafe_b64encode(json.dumps(part).encode()).decode() for part in (header, GOOD))
    return ".".join([*parts, ""])


def by_the_public_key() -> str:
    """Return a token whose secret is the public key of the provider, which everybody knows."""
    text = unsigned({"alg": "HS256", "kid": RSA.kid}).rstrip(".")
    signature = hmac.digest(RSA.as_pem(private=False), text.encode(), "sha256")
    return f"{text}.{urlsafe_b64encode(signature).decode()}"


@pytest.mark.parametrize(
    "forged",
    [
        lambda: unsigned({"alg": "none", "kid": "RS256"}),
        lambda: unsigned({"alg": "none"}),
        lambda: unsigned({"alg": "RS256", "kid": "RS256"}),
        lambda: unsigned({"alg": ["RS256"], "kid": "RS256"}),
        lambda: unsigned({"kid": "RS256"}),
        by_the_public_key,
        lambda: signed(GOOD, RSAKey.import_key(RSA.as_pem(private=True), {"kid": "RS256"}), "RS512"),
        lambda: signed(GOOD, ELLIPTIC)[:-8] + "AAAAAAAA",
        lambda: signed(GOOD, RSA, typ="logout+jwt"),
        lambda: unsigned({"alg": "RS256", "kid": "RS256", "typ": ["JWT"]}),
        lambda: signed(GOOD, RSA).replace(".", ""),
        lambda: signed(GOOD | {"groups": "x" * MAX_TOKEN}, RSA),
        lambda: "",
        lambda: "..",
        lambda: "é.é.é",
        lambda: f"{urlsafe_b64encode(b'[]').decode()}.e30.AA",
    ],
)
def test_a_forged_token_is_refused(forged: Callable[[], str]) -> None:
    with pytest.raises(NotAuthenticated, match="refused"):
        claims_of(forged())


def test_a_token_that_names_no_key_needs_a_provider_with_one() -> None:
    token = jwt.encode({"alg": "RS256"}, GOOD, RSA)
    with pytest.raises(UnknownKey):
        claims_of(token)
    assert signed_claims(token, KeySet([RSA]), ["RS256"], TYPES_OF_IDS) == GOOD


def check(change: dict[str, Any], nonce: str | None = "n") -> None:
    claims = {name: value for name, value in (GOOD | change).items() if value is not None}
    check_id_token(claims, SETTINGS, NOW, nonce)


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"exp": NOW - 59, "iat": NOW - 300},
        {"iat": NOW + 59, "nbf": NOW + 59},
        {"aud": ["ppaas"]},
        {"aud": ["ppaas", "other"], "azp": "ppaas"},
        {"azp": "ppaas"},
    ],
)
def test_a_token_for_this_login_is_taken_with_the_leeway_of_clocks(change: dict[str, Any]) -> None:
    check(change)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"iss": "https://evil.example"}, "iss"),
        ({"iss": f"{ISSUER}/"}, "iss"),
        ({"iss": [ISSUER, "https://evil.example"]}, "iss|aud|sub"),
        ({"iss": None}, "iss"),
        ({"aud": "other"}, "aud"),
        ({"aud": ["other"]}, "aud"),
        ({"aud": []}, "aud"),
        ({"aud": {"ppaas": 1}}, "iss|aud|sub"),
        ({"aud": None}, "aud"),
        ({"aud": ["ppaas", "other"]}, "azp"),
        ({"azp": "other"}, "azp"),
        ({"sub": None}, "sub"),
        ({"sub": ""}, "sub"),
        ({"sub": 7}, "iss|aud|sub"),
        ({"sub": "x" * 256}, "sub"),
        ({"sub": "ann\n"}, "sub"),
        ({"exp": NOW - 62}, "expired"),
        ({"exp": None}, "exp"),
        ({"exp": math.nan}, "exp"),
        ({"exp": math.inf}, "exp"),
        ({"exp": "1900000000"}, "exp"),
        ({"exp": True}, "exp"),
        ({"nbf": NOW + 62}, "not valid yet|not yet valid"),
        ({"iat": NOW + 62}, "future"),
        ({"iat": None}, "iat"),
        ({"nonce": "other"}, "nonce"),
        ({"nonce": None}, "nonce"),
        ({"nonce": ["n"]}, "nonce"),
    ],
)
def test_a_lie_is_refused_by_name(change: dict[str, Any], why: str) -> None:
    with pytest.raises(NotAuthenticated, match=why):
        check(change)


def test_a_token_of_a_device_has_no_nonce() -> None:
    check({"nonce": None}, nonce=None)


def test_an_access_token_is_for_the_audience_of_the_cloud_alone() -> None:
    access = {name: value for name, value in GOOD.items() if name not in ("nonce", "iat")} | {"aud": "ppaas-api"}
    check_access_token(access, SETTINGS, NOW)
    check_access_token(access | {"aud": ["account", "ppaas-api"], "azp": "fleet"}, SETTINGS, NOW)
    for change in ({"aud": "ppaas"}, {"exp": NOW - 62}, {"iss": "https://evil.example"}):
        with pytest.raises(NotAuthenticated):
            check_access_token(access | change, SETTINGS, NOW)


@pytest.mark.parametrize("kind", ["at+jwt", "application/at+jwt", "JWT"])
def test_types_of_access_tokens_are_no_types_of_logins(kind: str) -> None:
    token = signed(GOOD, RSA, typ=kind)
    assert claims_of(token, TYPES_OF_ACCESS) == GOOD
    if kind != "JWT":
        with pytest.raises(NotAuthenticated, match="type"):
            claims_of(token)


# Logouts.

OUT = {
    "iss": ISSUER, "aud": "ppaas", "sub": "id-of-ann", "sid": "s1", "jti": "7", "iat": NOW, "exp": NOW + 120,
    "events": {LOGOUT: {}},
}  # fmt: skip


def without(claims: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: value for name, value in claims.items() if name not in names}


@pytest.mark.parametrize("missing", ["", "sub", "sid"])
def test_a_logout_of_a_person_or_a_session_is_taken(missing: str) -> None:
    check_logout_token(without(OUT, missing), SETTINGS, NOW)
    check_logout_token(OUT | {"aud": ["another", "ppaas"], "more": 1}, SETTINGS, NOW + 179)


@pytest.mark.parametrize("missing", ["iss", "aud", "iat", "exp", "jti", "events"])
def test_a_logout_without_a_claim_is_refused(missing: str) -> None:
    with pytest.raises(NotAuthenticated, match=missing):
        check_logout_token(without(OUT, missing), SETTINGS, NOW)


@pytest.mark.parametrize(
    ("lie", "why"),
    [
        ({"iss": "https://evil.example"}, "iss"),
        ({"aud": "another"}, "aud"),
        ({"aud": []}, "aud"),
        ({"exp": NOW - 61}, "expired"),
        ({"iat": NOW + 3600}, "in the future"),
        ({"iat": "now"}, "iat"),
        ({"nonce": "n"}, "nonce"),
        ({"nonce": None}, "nonce"),
        ({"events": {}}, "events"),
        ({"events": {LOGOUT: True}}, "events"),
        ({"events": [LOGOUT]}, "events"),
        ({"events": {"https://schemas.openid.net/event/other": {}}}, "events"),
        ({"sid": ""}, "sid"),
        ({"sid": 7}, "sid"),
        ({"sid": "s" * 256}, "sid"),
        ({"sub": ""}, "sub"),
        ({"sub": "s" * 256}, "sub"),
        ({"jti": ""}, "jti"),
        ({"jti": ["7"]}, "jti"),
    ],
)
def test_a_logout_that_lies_is_refused(lie: dict[str, Any], why: str) -> None:
    with pytest.raises(NotAuthenticated, match=why):
        check_logout_token(OUT | lie, SETTINGS, NOW)


def test_a_logout_of_nobody_is_refused() -> None:
    with pytest.raises(NotAuthenticated, match="neither a person"):
        check_logout_token(without(OUT, "sub", "sid"), SETTINGS, NOW)


def test_a_token_that_says_who_somebody_is_reports_no_logout() -> None:
    with pytest.raises(NotAuthenticated):
        check_logout_token(without(GOOD, "nonce"), SETTINGS, NOW)


@pytest.mark.parametrize(("kind", "taken"), [("logout+jwt", True), ("JWT", True), ("at+jwt", False), ("x", False)])
def test_the_type_of_a_logout(kind: str, taken: bool) -> None:
    token = signed(OUT, RSA, typ=kind)
    if taken:
        assert claims_of(token, TYPES_OF_LOGOUT) == OUT
    else:
        with pytest.raises(NotAuthenticated, match="type"):
            claims_of(token, TYPES_OF_LOGOUT)
