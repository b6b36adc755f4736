"""Identity provider of a cloud: what it publishes about itself, its keys, and the exchanges in which it vouches."""

import asyncio
import logging
import ssl
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import httpx2
import msgspec
from authlib.integrations.base_client import OAuthError
from authlib.integrations.httpx_client import AsyncOAuth2Client
from authlib.oauth2.rfc7636 import create_s256_code_challenge
from joserfc.errors import JoseError
from joserfc.jwk import JWKRegistry, KeySet

from endpoints.oidc.http_client import TIMEOUT, BoundedTransport
from endpoints.oidc.settings import OidcSettings, client_secret, secure_endpoint
from ppaas.clock import Clock, monotonic
from ppaas.decoding import converted
from ppaas.errors import InvalidInput, NotAuthenticated, Unavailable

logger = logging.getLogger(__name__)

LIFETIME = 3600.0
"""Time for which what the provider publishes is used [s]: a key that it withdraws is taken for no longer."""

RETRY = 2.0
"""Time for which the provider is not asked again after it could not be read [s]: logins fail at once, not in a row."""

PAUSE = 30.0
"""Least time between two looks for a new key [s]: tokens with invented keys cause no more."""

WHOLE = 10.0
"""Time limit of an exchange as a whole [s]."""

MOST = 16
"""Largest number of exchanges at a time."""

MAX_WORDS = 200
"""Longest text of the provider that is shown [characters]."""

WELL_KNOWN = "/.well-known/openid-configuration"
DEVICE_CODE = "urn:ietf:params:oauth:grant-type:device_code"

_KEY_TYPES = frozenset({"RSA", "EC", "OKP"})
"""Types of keys that are taken from a provider: with a secret as a key, its readers could sign."""

_UNFINISHED = frozenset({"authorization_pending", "slow_down"})
"""Answers to a device whose person has not logged in yet (RFC 8628, 3.5)."""

_WRONG_CLIENT = frozenset({"invalid_client", "unauthorized_client", "unsupported_grant_type", "invalid_scope"})
"""Answers for which the settings are wrong, of this cloud or at the provider."""


class ProviderMetadata(msgspec.Struct, frozen=True):
    """What a provider publishes about itself (OpenID Connect Discovery 1.0, 3), as far as it is needed."""

    issuer: str
    authorization_endpoint: str
    token_endpoint: str
    jwks_uri: str
    device_authorization_endpoint: str | None = None
    end_session_endpoint: str | None = None


class DeviceCode(msgspec.Struct, frozen=True):
    """Code that a person enters at the provider, and the one by which the device asks whether it was (RFC 8628)."""

    device_code: str
    user_code: str
    verification_uri: str
    expires_in: float
    verification_uri_complete: str | None = None
    interval: float = 5.0


class LoginPending(Exception):
    """The person has not logged in yet. ``slower`` is whether the device asks too often."""

    def __init__(self, *, slower: bool) -> None:
        super().__init__("the person has not logged in yet")
        self.slower = slower


class IdentityProvider:
    """Client of an identity provider.

    Parameters
    ----------
    settings : OidcSettings
    clock : callable
        Returns monotonic time [s].
    timeout : float
        Time limit of each part of an exchange [s].
    """

    def __init__(self, settings: OidcSettings, clock: Clock = monotonic, *, timeout: float = TIMEOUT) -> None:
        self._settings = settings
        self._clock = clock
        self._timeout = timeout
        self._trusted = ssl.create_default_context()
        self._lock = asyncio.Lock()
        self._turns = asyncio.Semaphore(MOST)
        self._published: ProviderMetadata | None = None
        self._keys: KeySet | None = None
        self._read = self._looked = -LIFETIME
        self._failure: tuple[float, Unavailable] | None = None

    async def published(self) -> ProviderMetadata:
        """Return what the provider publishes about itself; ``Unavailable`` if it cannot be read, or is not its own."""
        async with self._lock:
            return (await self._current())[0]

    async def keys(self, *, look: bool = False) -> KeySet:
        """Return the keys of the provider; with ``look`` read them again, unless that was done a moment ago.

        Raises
        ------
        Unavailable
            They cannot be read.
        """
        async with self._lock:
            published, keys = await self._current()
            if look and self._clock() - self._looked >= PAUSE:
                self._looked = self._clock()
                self._keys = keys = _key_set(await self._get(published.jwks_uri))
            return keys

    async def token_for_code(self, code: str, verifier: str) -> Mapping[str, Any]:
        """Return the answer to a code that a browser has brought; `_exchange` names the errors."""
        published = await self.published()
        return await self._exchange(
            published.token_endpoint,
            grant_type="authorization_code",
            code=code,
            code_verifier=verifier,
            redirect_uri=self._settings.redirect,
        )

    async def token_for_device(self, code: str, verifier: str) -> Mapping[str, Any]:
        """Return the answer to a code of a device; `LoginPending` while its person has not logged in."""
        published = await self.published()
        return await self._exchange(
            published.token_endpoint, grant_type=DEVICE_CODE, device_code=code, code_verifier=verifier
        )

    async def device_code(self, verifier: str) -> DeviceCode:
        """Return codes for the login of a device; ``NotAuthenticated`` if the provider has no such logins.

        It is sent with PKCE, too, which RFC 8628 lacks: Keycloak wants it of clients that must use PKCE.
        """
        endpoint = (await self.published()).device_authorization_endpoint
        if endpoint is None:
            raise NotAuthenticated("this identity provider has no logins of devices: log in with a password")
        async with self._client() as client:
            # What authenticates the client is the same as for tokens (RFC 8628, 3.1).
            answer = await client.post(
                endpoint,
                data={
                    "client_id": self._settings.client_id,
                    "scope": self._settings.scope,
                    "code_challenge": create_s256_code_challenge(verifier),
                    "code_challenge_method": "S256",
                },
                auth=client.client_auth(client.token_endpoint_auth_method),
            )
            found = self._checked(answer)
        try:
            code = converted(found, DeviceCode, strict=False)
            secure_endpoint(code.verification_uri)
        except (msgspec.ValidationError, InvalidInput) as error:
            raise self._strange(error) from error
        return code

    async def _current(self) -> tuple[ProviderMetadata, KeySet]:
        """Return what is known, read again if it is old. The lock is held."""
        if self._published is not None and self._keys is not None and self._clock() - self._read < LIFETIME:
            return self._published, self._keys
        if self._failure is not None and self._clock() - self._failure[0] < RETRY:
            raise self._failure[1]
        try:
            published = self._own(await self._get(f"{self._settings.issuer.rstrip('/')}{WELL_KNOWN}"))
            keys = _key_set(await self._get(published.jwks_uri))
        except Unavailable as error:
            self._failure = self._clock(), error
            raise
        self._published, self._keys = published, keys
        self._read = self._clock()
        return published, keys

    def _own(self, found: Any) -> ProviderMetadata:
        try:
            published = converted(found, ProviderMetadata)
            for url in (published.authorization_endpoint, published.token_endpoint, published.jwks_uri):
                secure_endpoint(url)
            for optional in (published.device_authorization_endpoint, published.end_session_endpoint):
                secure_endpoint(optional or published.issuer)
        except (msgspec.ValidationError, InvalidInput) as error:
            raise self._strange(error) from error
        if published.issuer != self._settings.issuer:
            raise self._strange(f"it calls itself {published.issuer!a}")
        return published

    async def _exchange(self, url: str, **form: str) -> Mapping[str, Any]:
        """Return the answer of the endpoint of tokens.

        Raises
        ------
        LoginPending
            The person of a device has not logged in yet.
        NotAuthenticated
            The provider refuses the code.
        Unavailable
            It does not answer, or refuses this cloud.
        """
        async with self._client() as client:
            try:
                return dict(await client.fetch_token(url, **form))
            except OAuthError as error:
                raise self._refused(str(error.error), str(error.description or "")) from error
            except httpx2.HTTPStatusError as error:
                raise self._strange(f"it answers {error.response.status_code}") from error
            except (ValueError, TypeError) as error:  # of an answer that is no token
                raise self._strange(error) from error

    async def _get(self, url: str) -> Any:
        async with self._client() as client:
            return self._checked(await client.request("GET", url, withhold_token=True))

    def _checked(self, answer: httpx2.Response) -> Any:
        """Return the JSON of an answer; raise what it reports."""
        try:
            found = answer.json()
        except ValueError as error:
            raise self._strange(f"it answers {answer.status_code} without JSON") from error
        if isinstance(found, dict) and "error" in found:
            raise self._refused(str(found["error"]), str(found.get("error_description") or ""))
        if answer.status_code != httpx2.codes.OK or not isinstance(found, dict):
            raise self._strange(f"it answers {answer.status_code}")
        return found

    def _refused(self, code: str, words: str) -> Exception:
        if code in _UNFINISHED:
            return LoginPending(slower=code == "slow_down")
        shown = "".join(each if each.isprintable() else " " for each in f"{code}: {words}".rstrip(": "))[:MAX_WORDS]
        if code in _WRONG_CLIENT:
            logger.warning("the identity provider refuses this cloud: %s", shown)
            return Unavailable(f"the identity provider refuses this cloud, whose settings are wrong: {shown}")
        return NotAuthenticated(f"the identity provider refuses the login: {shown}; begin again")

    def _strange(self, why: object) -> Unavailable:
        logger.warning("%s is not the identity provider of the settings: %s", self._settings.issuer, why)
        return Unavailable(
            f"{self._settings.issuer} does not answer like an identity provider: {why}",
            public="the identity provider of this cloud does not answer like one: see the log of the cloud; passwords "
            "and tokens work as before",
        )

    @asynccontextmanager
    async def _client(self) -> AsyncIterator[AsyncOAuth2Client]:
        """Return a client for one exchange."""
        if self._turns.locked():
            raise Unavailable("too many people log in with the identity provider at this moment: try again")
        secret = await asyncio.to_thread(self._secret)
        try:
            async with (
                self._turns,
                asyncio.timeout(WHOLE),
                AsyncOAuth2Client(
                    self._settings.client_id,
                    secret,
                    transport=BoundedTransport(self._trusted),
                    timeout=self._timeout,
                    follow_redirects=False,
                ) as client,
            ):
                yield client
        except (httpx2.TransportError, TimeoutError) as error:
            logger.warning("the identity provider %s is away: %s", self._settings.issuer, error or type(error).__name__)
            raise Unavailable(
                "the identity provider of this cloud does not answer: try again later; passwords and tokens work as "
                "before"
            ) from error

    def _secret(self) -> str | None:
        if not self._settings.secret_file:
            return None
        try:
            return client_secret(Path(self._settings.secret_file))
        except InvalidInput as error:
            logger.warning("%s", error)
            raise Unavailable(
                str(error), public="the client of the identity provider has no secret: see the log of the cloud"
            ) from error


def _key_set(found: Any) -> KeySet:
    """Return the keys for signatures in an answer; keys that are none, or cannot be read, are left out."""
    listed = found.get("keys") if isinstance(found, dict) else None
    keys = []
    for each in listed if isinstance(listed, list) else ():
        if isinstance(each, dict) and each.get("kty") in _KEY_TYPES and each.get("use", "sig") == "sig":
            try:
                keys.append(JWKRegistry.import_key(each))
            except (JoseError, ValueError, TypeError, KeyError) as error:
                logger.debug("a key of the identity provider is not read: %s", error)
    if not keys:
        raise Unavailable("the identity provider publishes no key that this cloud can use")
    return KeySet(keys)
