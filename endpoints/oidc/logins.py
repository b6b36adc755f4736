"""Logins with an identity provider: of browsers by codes, of devices, and of programs that have an access token."""

import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlencode, urlsplit

from authlib.integrations.httpx_client import AsyncOAuth2Client
from joserfc.jwk import KeySet

from endpoints.oidc.person import ProvidedPerson, person_of
from endpoints.oidc.provider import DeviceCode, IdentityProvider
from endpoints.oidc.settings import OidcSettings
from endpoints.oidc.tokens import (
    TYPES_OF_ACCESS,
    TYPES_OF_IDS,
    TYPES_OF_LOGOUT,
    Claims,
    UnknownKey,
    check_access_token,
    check_id_token,
    check_logout_token,
    is_session,
    signed_claims,
)
from ppaas.clock import Clock, epoch
from ppaas.errors import NotAuthenticated

SECRET = 32
"""Size of what only the browser of a login knows [bytes]."""


@dataclass(frozen=True, slots=True)
class LoginStart:
    """Login of a browser that begins.

    Parameters
    ----------
    url : str
        Address at the provider where it goes on.
    state, nonce, verifier : str
        What the browser keeps until the provider sends it back: the first is in the address then, the others are for
        `OidcLogins.by_code`.
    """

    url: str
    state: str
    nonce: str
    verifier: str


@dataclass(frozen=True, slots=True)
class Vouched:
    """Person for whom the provider vouches, the longest time for which it does [s], its session, and its logout."""

    person: ProvidedPerson
    lifetime: float
    session: str = ""
    logout_url: str | None = None


@dataclass(frozen=True, slots=True)
class ProviderLogout:
    """Logout that the provider reports.

    Parameters
    ----------
    issuer : str
    subject : str, optional
        Person; None if only the session is known.
    session : str, optional
        Session that has ended; None for all of the person.
    before : float
        Time until which sessions may have begun that end [s since the epoch].
    """

    issuer: str
    subject: str | None
    session: str | None
    before: float


class OidcLogins:
    """Logins with an identity provider; they keep nothing, so each endpoint can end what another one began.

    Parameters
    ----------
    settings : OidcSettings
    provider : IdentityProvider
    clock : callable
        Returns the time [s since the epoch].
    """

    def __init__(self, settings: OidcSettings, provider: IdentityProvider | None = None, clock: Clock = epoch) -> None:
        self._settings = settings
        self._provider = provider or IdentityProvider(settings)
        self._clock = clock

    @property
    def name(self) -> str:
        """Name of the provider."""
        return self._settings.shown_name

    async def begin(self, *, again: bool = False) -> LoginStart:
        """Return the start of the login of a browser; ``Unavailable`` if the provider does not answer.

        With ``again`` the provider asks who it is, also somebody who has logged in there.
        """
        published = await self._provider.published()
        verifier, nonce, state = (secrets.token_urlsafe(SECRET) for _ in range(3))
        client = AsyncOAuth2Client(
            self._settings.client_id,
            redirect_uri=self._settings.redirect,
            scope=self._settings.scope,
            code_challenge_method="S256",
        )
        asked = {"prompt": "login"} if again else {}
        url, _ = client.create_authorization_url(
            published.authorization_endpoint, state=state, nonce=nonce, code_verifier=verifier, **asked
        )
        return LoginStart(url, state, nonce, verifier)

    async def by_code(self, code: str, verifier: str, nonce: str, issuer: str | None) -> Vouched:
        """Return the person of a browser that the provider has sent back.

        Parameters
        ----------
        code : str
            Code in the address.
        verifier, nonce : str
            Of the start of the login.
        issuer : str, optional
            Issuer in the address, if there is one (RFC 9207).

        Raises
        ------
        NotAuthenticated
            The code, or the token for it, is refused.
        NotPermitted
            None of the person's groups has a role.
        Unavailable
            The provider does not answer.
        """
        if issuer not in (None, self._settings.issuer):
            raise NotAuthenticated("another identity provider has sent you here: log in again")
        return await self._person_of(await self._provider.token_for_code(code, verifier), nonce)

    async def begin_device(self) -> tuple[DeviceCode, str]:
        """Return codes for the login of a device, and its verifier; raises as `IdentityProvider.device_code`."""
        verifier = secrets.token_urlsafe(SECRET)
        return await self._provider.device_code(verifier), verifier

    async def by_device(self, device_code: str, verifier: str) -> Vouched:
        """Return the person of a device; ``LoginPending`` while nobody has logged in, else raises as `by_code`."""
        return await self._person_of(await self._provider.token_for_device(device_code, verifier), None)

    async def by_access_token(self, token: str) -> Vouched:
        """Return the person or program of an access token for this cloud, until it expires.

        Raises
        ------
        NotAuthenticated
            The token is refused, or this cloud takes none.
        NotPermitted
            None of the groups has a role.
        Unavailable
            The provider does not answer.
        """
        if not self._settings.audience:
            raise NotAuthenticated("this cloud takes no access tokens of its identity provider (--oidc-audience)")
        claims = await self._signed(token, TYPES_OF_ACCESS)
        now = self._clock()
        check_access_token(claims, self._settings, now)
        until = min(claims["exp"], now + self._settings.session)  # before the difference: it may be any number
        person = person_of(claims, self._settings, is_program=True)
        return Vouched(person, max(1.0, until - now), _session_of(claims))

    async def logout(self, token: str) -> ProviderLogout:
        """Return the logout that a token of the provider reports.

        Raises
        ------
        NotAuthenticated
            The token is refused.
        Unavailable
            The provider's keys cannot be read.
        """
        claims = await self._signed(token, TYPES_OF_LOGOUT)
        check_logout_token(claims, self._settings, self._clock())
        # A session that begins after the logout stays, also if the token is sent once more.
        before = claims["iat"] + self._settings.leeway
        return ProviderLogout(claims["iss"], claims.get("sub"), claims.get("sid"), before)

    async def _person_of(self, answer: Mapping[str, Any], nonce: str | None) -> Vouched:
        token = answer.get("id_token")
        if not isinstance(token, str):
            raise NotAuthenticated("the identity provider does not say who you are: ask for the scope 'openid'")
        claims = await self._signed(token, TYPES_OF_IDS)
        check_id_token(claims, self._settings, self._clock(), nonce)
        person, url = person_of(claims, self._settings), await self._logout_url(token)
        return Vouched(person, self._settings.session, _session_of(claims), url)

    async def _signed(self, token: str, types: frozenset[str]) -> Claims:
        """Return what a token says; with a key that is not known, after a look for new ones."""

        def read(keys: KeySet) -> Claims:
            return signed_claims(token, keys, self._settings.allowed_algorithms, types)

        try:
            return read(await self._provider.keys())
        except UnknownKey:
            return read(await self._provider.keys(look=True))

    async def _logout_url(self, token: str) -> str | None:
        """Return the address at which the login at the provider ends (OpenID Connect RP-Initiated Logout 1.0, 2)."""
        endpoint = (await self._provider.published()).end_session_endpoint
        if endpoint is None:
            return None
        query = urlencode(
            {
                "id_token_hint": token,
                "client_id": self._settings.client_id,
                "post_logout_redirect_uri": self._settings.redirect,
            }
        )
        return f"{endpoint}{'&' if urlsplit(endpoint).query else '?'}{query}"


def _session_of(claims: Claims) -> str:
    """Return the provider's session in a token; empty if it names none."""
    found = claims.get("sid")
    return str(found) if is_session(found) else ""
