"""Authentication of HTTP requests by bearer token, and of the handshakes of WebSockets, also by ticket.

Tokens are taken from the header alone, because addresses are written to logs and histories (RFC 6750, 5.3; RFC 9700,
4.3.2). WebSockets of browsers, which cannot send the header, offer a subprotocol or give a ticket. A token in the
address of a WebSocket is taken, too, because clients of rosbridge may know no other way.
"""

from starlette.requests import HTTPConnection
from starlette.websockets import WebSocket

from endpoints.accounts.accounts import Accounts, token_id
from endpoints.accounts.caller import note_caller
from ppaas.errors import NotAuthenticated
from storage.records import User

BEARER_PROTOCOL = "ppaas.bearer."
"""Prefix of a subprotocol that carries a token."""

PROTOCOL = "ppaas"
"""Subprotocol that the cloud selects beside one with a token, if it is offered."""


def token_of(connection: HTTPConnection) -> str:
    """Return the bearer token of the header of a request.

    Raises
    ------
    NotAuthenticated
        There is no token, or only one in the address.
    """
    token = bearer_of(connection.headers.get("authorization", ""))
    if token:
        return token
    if "token" in connection.query_params:
        raise NotAuthenticated(
            "a token in the address is not taken, as addresses are logged: send it as 'Authorization: Bearer TOKEN'"
        )
    raise NotAuthenticated("no token: log in with POST /v1/tokens and send it as 'Authorization: Bearer TOKEN'")


def address_of(connection: HTTPConnection) -> str:
    """Return the address of the client, without its port; empty if it is unknown.

    Behind a trusted proxy, it is that of the client of the proxy (`endpoints.http.forwarding`).
    """
    return connection.client.host if connection.client is not None else ""


def bearer_of(authorization: str) -> str | None:
    """Return the token of an ``Authorization`` header, if it has one."""
    scheme, _, token = authorization.partition(" ")
    return token.strip() or None if scheme.lower() == "bearer" else None


async def authenticate(connection: HTTPConnection, accounts: Accounts) -> User:
    """Return the user of a connection; ``NotAuthenticated`` if the token is missing, unknown or expired."""
    token = token_of(connection)
    connection.state.user = user = await accounts.authenticate(token)
    note_caller(connection.scope, user.id, token_id(token))
    return user


async def authenticate_socket(socket: WebSocket, accounts: Accounts) -> tuple[User, str]:
    """Return the user of a handshake, and the id of the token; note both.

    The token is that of the header, else of the ticket, else of a subprotocol, else in the address.

    Raises
    ------
    NotAuthenticated
        There is none, or it is unknown or expired.
    """
    query = socket.query_params
    token = bearer_of(socket.headers.get("authorization", ""))
    if token is None and query.get("ticket"):
        used = accounts.tickets.redeem(query["ticket"])
        user = await accounts.user_of(used)
        note_caller(socket.scope, user.id, used)
        return user, used
    token = token or _offered_token(socket) or query.get("token", "").strip()
    if not token:
        raise NotAuthenticated(
            "no token: log in with POST /v1/tokens and send it as 'Authorization: Bearer TOKEN'; browsers get a ticket "
            "with POST /v1/tickets and add '&ticket=TICKET' to the address"
        )
    user, used = await accounts.authenticate(token), token_id(token)
    note_caller(socket.scope, user.id, used)
    return user, used


def subprotocol_of(socket: WebSocket) -> str | None:
    """Return the subprotocol to select: if a token is offered as one, a browser closes a handshake without any."""
    offered: list[str] = socket.scope.get("subprotocols", [])
    carriers = [protocol for protocol in offered if protocol.startswith(BEARER_PROTOCOL)]
    return PROTOCOL if PROTOCOL in offered else next(iter(carriers), None)


def _offered_token(socket: WebSocket) -> str | None:
    offered: list[str] = socket.scope.get("subprotocols", [])
    tokens = (protocol[len(BEARER_PROTOCOL) :] for protocol in offered if protocol.startswith(BEARER_PROTOCOL))
    return next(filter(None, tokens), None)
