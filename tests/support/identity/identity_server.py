"""A small identity provider over real sockets: honest, or lying in one way."""

import base64
import hashlib
import secrets
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import urlencode

from joserfc import jwt
from joserfc.jwk import ECKey, KeySet, OctKey, OKPKey, RSAKey
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, RedirectResponse, Response
from starlette.routing import Route

from tests.support.endpoints.serving import serve

Key = RSAKey | ECKey | OKPKey | OctKey

CLIENT, SECRET, AUDIENCE = "ppaas", "secret-of-the-client", "ppaas-api"


def new_key(kid: str, kind: str = "ES256") -> Key:
    """Return a new key pair for one kind of signature."""
    parameters: Any = {"kid": kid, "use": "sig", "alg": kind}
    if kind == "ES256":
        return ECKey.generate_key("P-256", parameters)
    if kind == "Ed25519":
        return OKPKey.generate_key("Ed25519", parameters)
    return RSAKey.generate_key(2048, parameters)


@dataclass
class Someone:
    """A person of the provider."""

    subject: str = "id-of-ann"
    claims: dict[str, Any] = field(default_factory=lambda: {"preferred_username": "ann", "groups": ["staff"]})


@dataclass
class IdentityServer:
    """State of the provider, which a test changes.

    ``alter`` is called with the claims of each token before it is signed, and may change them. ``sign`` replaces the
    signing. ``published`` are keys that it publishes; it signs with the last one.
    """

    issuer: str = ""
    keys: list[Key] = field(default_factory=lambda: [new_key("first")])
    person: Someone = field(default_factory=Someone)
    alter: Callable[[dict[str, Any]], None] = lambda _: None
    sign: Callable[[dict[str, Any]], str] | None = None
    metadata: dict[str, Any] = field(default_factory=dict)
    answers: dict[str, Response] = field(default_factory=dict)
    codes: dict[str, dict[str, str]] = field(default_factory=dict)
    devices: dict[str, bool] = field(default_factory=dict)
    challenges: dict[str, str] = field(default_factory=dict)
    expires_in: float = 60.0
    asked: list[str] = field(default_factory=list)

    def token(self, audience: str, **claims: Any) -> str:
        """Return a signed token about the person."""
        now = int(time.time())
        given = {"iss": self.issuer, "aud": audience, "sub": self.person.subject, "iat": now, "exp": now + 300}
        given |= self.person.claims | claims
        self.alter(given)
        return self.sign(given) if self.sign else self.signed(given, self.keys[-1])

    def logout_token(self, **claims: Any) -> str:
        """Return a signed report of a logout of the person (OpenID Connect Back-Channel Logout 1.0); None omits."""
        now = int(time.time())
        given = {
            "iss": self.issuer, "aud": CLIENT, "sub": self.person.subject, "iat": now, "exp": now + 120,
            "jti": secrets.token_urlsafe(8), "events": {"http://schemas.openid.net/event/backchannel-logout": {}},
        } | claims  # fmt: skip
        return self.signed({name: value for name, value in given.items() if value is not None}, self.keys[-1])

    @staticmethod
    def signed(claims: dict[str, Any], key: Key, algorithm: str | None = None, **header: Any) -> str:
        """Return claims signed with a key."""
        chosen = algorithm or key.as_dict().get("alg", "RS256")
        return jwt.encode({"alg": chosen, "kid": key.kid, **header}, claims, key, algorithms=[chosen])

    def app(self) -> Starlette:
        """Return the application."""
        return Starlette(
            routes=[
                Route("/.well-known/openid-configuration", self._metadata),
                Route("/keys", self._keys),
                Route("/authorize", self._authorize),
                Route("/device", self._device, methods=["POST"]),
                Route("/token", self._token, methods=["POST"]),
            ]
        )

    async def _metadata(self, request: Request) -> Response:
        self.asked.append("metadata")
        paths = {
            "authorization_endpoint": "authorize", "token_endpoint": "token", "jwks_uri": "keys",
            "device_authorization_endpoint": "device", "end_session_endpoint": "logout",
        }  # fmt: skip
        found = {"issuer": self.issuer} | {name: f"{self.issuer}/{path}" for name, path in paths.items()}
        return self.answers.get("metadata") or JSONResponse(found | self.metadata)

    async def _keys(self, request: Request) -> Response:
        self.asked.append("keys")
        return self.answers.get("keys") or JSONResponse(KeySet(self.keys).as_dict(private=False))

    async def _authorize(self, request: Request) -> Response:
        """Send the browser back at once: the person is logged in here already."""
        query = dict(request.query_params)
        code = secrets.token_urlsafe(16)
        self.codes[code] = query
        back = urlencode({"code": code, "state": query["state"], "iss": self.issuer})
        return RedirectResponse(f"{query['redirect_uri']}?{back}")

    async def _device(self, request: Request) -> Response:
        assert self._is_client(request)
        code, form = secrets.token_urlsafe(16), await request.form()
        self.devices[code] = False
        self.challenges[code] = str(form["code_challenge"])
        return self.answers.get("device") or JSONResponse(
            {
                "device_code": code, "user_code": "ABCD-EFGH", "verification_uri": f"{self.issuer}/activate",
                "expires_in": self.expires_in, "interval": 0,
            }
        )  # fmt: skip

    async def _token(self, request: Request) -> Response:
        self.asked.append("token")
        if "token" in self.answers:
            return self.answers["token"]
        if not self._is_client(request):
            return _problem("invalid_client")
        form = {name: str(value) for name, value in (await request.form()).items()}
        return self._of_code(form) if form["grant_type"] == "authorization_code" else self._of_device(form)

    def _of_code(self, form: dict[str, str]) -> Response:
        begun = self.codes.pop(form["code"], None)
        if begun is None or form["redirect_uri"] != begun["redirect_uri"]:
            return _problem("invalid_grant")
        if begun["code_challenge"] != challenge(form["code_verifier"]):
            return _problem("invalid_grant")
        return self._tokens(nonce=begun["nonce"])

    def _of_device(self, form: dict[str, str]) -> Response:
        if form["device_code"] not in self.devices:
            return _problem("expired_token")
        if challenge(form["code_verifier"]) != self.challenges[form["device_code"]]:
            return _problem("invalid_grant")
        return self._tokens() if self.devices[form["device_code"]] else _problem("authorization_pending")

    def _tokens(self, **claims: Any) -> Response:
        return JSONResponse(
            {"access_token": "not for this cloud", "token_type": "Bearer", "id_token": self.token(CLIENT, **claims)}
        )

    @staticmethod
    def _is_client(request: Request) -> bool:
        wanted = base64.b64encode(f"{CLIENT}:{SECRET}".encode()).decode()
        return request.headers.get("authorization") == f"Basic {wanted}"


def challenge(verifier: str) -> str:
    """Return the challenge of a verifier (RFC 7636, 4.2)."""
    return base64.urlsafe_b64encode(hashlib.sha256(verifier.encode()).digest()).rstrip(b"=").decode()


def _problem(error: str) -> Response:
    return JSONResponse({"error": error, "error_description": "as the test wants it"}, status_code=400)


@asynccontextmanager
async def identity_server() -> AsyncIterator[IdentityServer]:
    """Run a provider."""
    server = IdentityServer()
    async with serve(server.app()) as port:
        server.issuer = f"http://127.0.0.1:{port}"
        yield server
