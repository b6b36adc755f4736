"""Authentication of HTTP requests by token, and of the handshakes of WebSockets, also by ticket.

Tokens are taken from the header alone, because addresses are written to logs and histories (RFC 6750, 5.3; RFC 9700,
4.3.2). Clients that are given an address alone, ``ws://USER:TOKEN@HOST``, send user and token in the header, too, as
Basic credentials (RFC 7617). WebSockets of browsers, which cannot send the header, offer a subprotocol or give a
ticket. A token in the query of a WebSocket's address is taken, too, because clients of rosbridge may know no other way.
"""

import base64
from collections.abc import MutableMapping
from typing import Any, NamedTuple

from starlette.requests import HTTPConnection
from starlette.websockets import WebSocket

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.tokens import received_token_id
from ppaas.errors import NotAuthenticated
from storage.records import User

_KEY = "ppaas.caller"


class AuthenticatedUser(NamedTuple):
    """User of a connection, and id of the token that authenticated it."""

    user: str
    token: str


def note_caller(scope: MutableMapping[str, Any], user: str, token: str) -> None:
    """Note the user of a connection, and the id of the token."""
    scope[_KEY] = AuthenticatedUser(user, token)


def caller_of(scope: MutableMapping[str, Any]) -> AuthenticatedUser | None:
    """Return the caller of a connection; None if it is not authenticated."""
    return scope.get(_KEY)


BEARER_PROTOCOL = "ppaas.bearer."
"""Prefix of a subprotocol that carries a token."""

PROTOCOL = "ppaas"
"""Subprotocol that the cloud selects beside one with a token, if it is offered."""


class TokenClaim(NamedTuple):
    """Token of a request, and the user whose token the client says it is; None if it says none."""

    token: str
    user: str | None = None


def credentials_of(connection: HTTPConnection) -> TokenClaim:
    """Return the credentials in the header of a request.

    Raises
    ------
    NotAuthenticated
        There is no token, or only one in the address; or the Basic credentials are not a user and a token.
    """
    found = parse_credentials(connection.headers.get("authorization", ""))
    if found is not None:
        return found
    if "token" in connection.query_params:
        raise NotAuthenticated(
            "a token in the address is not taken, as addresses are logged: send it as 'Authorization: Bearer TOKEN'"
        )
    raise NotAuthenticated("no token: log in with POST /v1/tokens and send it as 'Authorization: Bearer TOKEN'")


def address_of(connection: HTTPConnection) -> str:
    """Return the address of the client, without its port; empty if it is unknown.

    Behind a trusted proxy, it is the address of the proxy's client (`endpoints.http.front`).
    """
    return connection.client.host if connection.client is not None else ""


def bearer_of(authorization: str) -> str | None:
    """Return the token of an ``Authorization`` header, if it has one."""
    scheme, _, token = authorization.partition(" ")
    return token.strip() or None if scheme.lower() == "bearer" else None


def parse_credentials(authorization: str) -> TokenClaim | None:
    """Return the credentials of an ``Authorization`` header, Bearer or Basic; None for another scheme, or no token.

    Raises
    ------
    NotAuthenticated
        The Basic credentials are not a user and a token.
    """
    scheme, _, text = authorization.partition(" ")
    if scheme.lower() == "basic":
        return _parse_basic(text.strip())
    token = bearer_of(authorization)
    return None if token is None else TokenClaim(token)


def _parse_basic(text: str) -> TokenClaim:
    """Return the credentials of the scheme Basic (RFC 7617). No error quotes them: either may be a token."""
    try:
        user, _, token = base64.b64decode(text, validate=True).decode().partition(":")
    except ValueError:  # neither base64 nor UTF-8
        user = token = ""
    if not user or not token:
        raise NotAuthenticated(
            "Basic credentials must be USER:TOKEN, as in ws://USER:TOKEN@HOST/?robot=ID: the name of a user, and in "
            "place of the password a token of this user from POST /v1/tokens"
        )
    return TokenClaim(token, user)


async def authenticate(connection: HTTPConnection, accounts: Accounts) -> User:
    """Return the user of a connection; ``NotAuthenticated`` if the token is missing, unknown, expired or another's."""
    user, _ = await _user_of(connection, credentials_of(connection), accounts)
    connection.state.user = user
    return user


async def _user_of(connection: HTTPConnection, credentials: TokenClaim, accounts: Accounts) -> tuple[User, str]:
    """Return the user of credentials, and the id of the token; note both."""
    used = received_token_id(credentials.token)
    user = await accounts.user_of(used)
    if credentials.user not in (None, user.id):
        raise NotAuthenticated("the token is not one of the user named before it: give the user who got the token")
    note_caller(connection.scope, user.id, used)
    return user, used


async def authenticate_socket(socket: WebSocket, accounts: Accounts) -> tuple[User, str]:
    """Return the user of a handshake, and the id of the token; note both.

    The token is taken from the header, else the ticket, else a subprotocol, else the address. Basic credentials
    count last: beside a token they may be for a proxy in between, whose password a browser sends to all behind it.

    Raises
    ------
    NotAuthenticated
        There is none, it is unknown or expired, or it is not one of the user that the header names.
    """
    query, authorization = socket.query_params, socket.headers.get("authorization", "")
    token = bearer_of(authorization)
    if token is None and query.get("ticket"):
        used = await accounts.redeem_ticket(query["ticket"])
        user = await accounts.user_of(used)
        note_caller(socket.scope, user.id, used)
        return user, used
    token = token or _offered_token(socket) or query.get("token", "").strip()
    credentials = TokenClaim(token) if token else parse_credentials(authorization)
    if credentials is None:
        raise NotAuthenticated(
            "no token: log in with POST /v1/tokens and send it as 'Authorization: Bearer TOKEN', or connect to "
            "ws://USER:TOKEN@HOST/?robot=ID; browsers get a ticket with POST /v1/tickets and add '&ticket=TICKET' to "
            "the address"
        )
    return await _user_of(socket, credentials, accounts)


def subprotocol_of(socket: WebSocket) -> str | None:
    """Return the subprotocol to select: if a token is offered as one, a browser closes a handshake without any."""
    offered = _offered(socket)
    return PROTOCOL if PROTOCOL in offered else next(filter(_has_token, offered), None)


def _offered_token(socket: WebSocket) -> str:
    tokens = (protocol.removeprefix(BEARER_PROTOCOL) for protocol in _offered(socket) if _has_token(protocol))
    return next(filter(None, tokens), "")


def _offered(socket: WebSocket) -> list[str]:
    offered: list[str] = socket.scope.get("subprotocols", [])
    return offered


def _has_token(protocol: str) -> bool:
    return protocol.startswith(BEARER_PROTOCOL)
