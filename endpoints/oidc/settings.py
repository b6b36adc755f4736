"""Settings of the login with an identity provider, and the parsers of its options."""

import argparse
import ipaddress
import re
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Literal, get_args
from urllib.parse import urlsplit

from ppaas.distribution import check_versions, install_hint
from ppaas.errors import InvalidInput

ProvidedRole = Literal["admin", "user"]
"""Role that a group of the provider gives."""

EVERYBODY = "*"
"""Group that stands for all people of the provider."""

ALGORITHMS = (
    "RS256", "RS384", "RS512", "PS256", "PS384", "PS512", "ES256", "ES384", "ES512", "EdDSA", "Ed25519",
)  # fmt: skip
"""Signatures that may be allowed. Each has a key pair: with HMAC, a public key of the provider would be the secret."""

USUAL_ALGORITHMS = ("RS256", "PS256", "ES256", "Ed25519")
USUAL_SCOPES = ("openid", "profile")

_SCOPE = re.compile(r"[\x21\x23-\x5b\x5d-\x7e]+")
"""Characters of a scope (RFC 6749, 3.3)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OidcSettings:
    """Settings of the login with an identity provider.

    Parameters
    ----------
    issuer : str
        URL of the provider, exactly as its tokens name it.
    client_id : str
        Id under which the provider knows this cloud.
    cloud_url : str
        Address of this cloud for browsers, without its last slash; the provider sends people back to it.
    roles : tuple of (str, str)
        Groups, with the role that each gives. Who is in none of them may not log in.
    secret_file : str
        File with the secret of the client; empty for a public client.
    name : str
        Name of the provider on the login page; empty for its host.
    scopes, algorithms : tuple of str
        Scopes that are asked for, and signatures that are taken; empty for the usual ones.
    audience : str
        Audience of access tokens that are taken in exchange for a token of the cloud; empty if none are.
    groups_claim, username_claim : str
        Claims with the groups and the name of a person; parts of a path are separated by dots.
    leeway : float
        Difference of the clocks that is tolerated [s].
    session : float
        Lifetime of the token of a login [s].
    """

    issuer: str
    client_id: str
    cloud_url: str
    roles: tuple[tuple[str, ProvidedRole], ...]
    secret_file: str = ""
    name: str = ""
    scopes: tuple[str, ...] = ()
    algorithms: tuple[str, ...] = ()
    audience: str = ""
    groups_claim: str = "groups"
    username_claim: str = "preferred_username"
    leeway: float = 60.0
    session: float = 43_200.0

    @property
    def redirect(self) -> str:
        """Address to which the provider sends people back: the only one, whatever a request says."""
        return f"{self.cloud_url}/dashboard/"

    @property
    def shown_name(self) -> str:
        """Name of the provider on the login page."""
        return self.name or (urlsplit(self.issuer).hostname or "")

    @property
    def allowed_algorithms(self) -> tuple[str, ...]:
        """Signatures that are taken."""
        return self.algorithms or USUAL_ALGORITHMS

    @property
    def scope(self) -> str:
        """Scopes that are asked for, as requests have them."""
        return " ".join(dict.fromkeys(("openid", *(self.scopes or USUAL_SCOPES))))

    def role_of(self, groups: frozenset[str]) -> ProvidedRole | None:
        """Return the highest role that some groups give; None if they give none."""
        given = {role for group, role in self.roles if group == EVERYBODY or group in groups}
        return next((role for role in get_args(ProvidedRole) if role in given), None)


NEEDED = ("issuer", "client_id", "cloud_url", "role")
GIVEN = (*NEEDED, "client_secret_file", "audience", "name", "scope", "algorithm")
"""Options, without their prefix, of which none has a default."""


def provider_settings(arguments: argparse.Namespace) -> OidcSettings | None:
    """Return the settings from the options that ``endpoints.cli.oidc_options`` adds; None if there are none.

    Raises
    ------
    InvalidInput
        Some are missing or do not fit together, the extra is not installed, or the secret cannot be read.
    """
    given = {name: getattr(arguments, f"oidc_{name}") for name in GIVEN}
    if not any(given.values()):
        return None
    missing = [f"--oidc-{name.replace('_', '-')}" for name in NEEDED if not given[name]]
    if missing:
        advice = "; --oidc-role '*=user' lets in everybody whom the provider knows" if "--oidc-role" in missing else ""
        raise InvalidInput(f"a login with an identity provider needs {', '.join(missing)}, too{advice}")
    if given["audience"] == given["client_id"]:
        # Tokens that say who somebody is have the client as their audience: they would be taken as rights.
        raise InvalidInput("--oidc-audience must not be the client: have the provider name this cloud differently")
    if find_spec("authlib") is None or find_spec("joserfc") is None:
        raise InvalidInput(f"--oidc-issuer needs the extra oidc: {install_hint('cloud', 'oidc')}")
    check_versions("oidc")
    secret = given["client_secret_file"]
    if secret is not None:
        client_secret(secret)
    return OidcSettings(
        issuer=given["issuer"],
        client_id=given["client_id"],
        cloud_url=given["cloud_url"],
        roles=tuple(given["role"]),
        secret_file="" if secret is None else str(secret.resolve()),
        name=given["name"] or "",
        scopes=tuple(given["scope"]),
        algorithms=tuple(given["algorithm"]),
        audience=given["audience"] or "",
        groups_claim=arguments.oidc_groups_claim,
        username_claim=arguments.oidc_username_claim,
        leeway=arguments.oidc_leeway,
        session=arguments.oidc_session,
    )


def client_secret(file: Path) -> str:
    """Return the secret in a file; ``InvalidInput`` if it cannot be read or is empty."""
    try:
        secret = file.read_text(encoding="utf-8-sig").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"cannot read the secret of the identity provider's client: {error}") from error
    if not secret:
        raise InvalidInput(f"the secret of the identity provider's client is empty: {file}")
    return secret


# Parsers of options.


def secure_url(text: str) -> str:
    """Return a URL without its last slash; ``InvalidInput`` unless it is of HTTPS, or of this computer."""
    found = secure_endpoint(text)
    if urlsplit(found).query:
        raise InvalidInput(f"a URL without a query is needed, not {text!a}")
    return found.rstrip("/")


def issuer_url(text: str) -> str:
    """Return the URL of an issuer, unchanged, as tokens must name it; raises as `secure_url`."""
    secure_url(text)
    return text


def secure_endpoint(text: str) -> str:
    """Return a URL, which may have a query; ``InvalidInput`` unless it is of HTTPS, or of this computer."""
    try:
        parts = urlsplit(text)
        whole = bool(parts.hostname) and parts.port != 0 and text.isprintable() and " " not in text
    except ValueError:
        whole = False
    if not whole or parts.username is not None or parts.fragment:
        raise InvalidInput(f"give a URL such as https://login.example/realms/lab, not {text!a}")
    if parts.scheme != "https" and not (parts.scheme == "http" and _is_loopback(parts.hostname or "")):
        raise InvalidInput(f"{text!a} must be of https: who reads or changes what it sends logs in as anybody")
    return text


def group_role(text: str) -> tuple[str, str]:
    """Return the group and the role in an argument ``GROUP=ROLE``; ``InvalidInput`` unless it is one."""
    group, _, role = text.rpartition("=")
    if not group or role not in get_args(ProvidedRole):
        raise InvalidInput(f"give GROUP=admin or GROUP=user, or *=user for everybody, not {text!a}")
    return group, role


def algorithm(text: str) -> str:
    """Return the algorithm in an argument; ``InvalidInput`` unless it has a key pair."""
    if text not in ALGORITHMS:
        raise InvalidInput(f"{text!a} is no signature with a key pair: choose from {', '.join(ALGORITHMS)}")
    return text


def scope(text: str) -> str:
    """Return the scope in an argument; ``InvalidInput`` unless it is one."""
    if not _SCOPE.fullmatch(text):
        raise InvalidInput(f"a scope has no spaces, quotes or backslashes, unlike {text!a}: repeat the option instead")
    return text


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
