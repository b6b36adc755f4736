"""Authentication of HTTP requests and WebSocket handshakes by bearer token."""

from starlette.requests import HTTPConnection

from endpoints.accounts.accounts import Accounts
from ppaas.errors import NotAuthenticated
from storage.records import User


def token_of(connection: HTTPConnection) -> str:
    """Return the bearer token of a header, else of the query.

    Raises
    ------
    NotAuthenticated
        There is no token.
    """
    token = bearer_of(connection.headers.get("authorization", "")) or connection.query_params.get("token", "").strip()
    if not token:
        raise NotAuthenticated("no token: log in with POST /v1/tokens and send it as 'Authorization: Bearer TOKEN'")
    return token


def address_of(connection: HTTPConnection) -> str:
    """Return the address of the client, without its port; empty if it is unknown."""
    return connection.client.host if connection.client is not None else ""


def bearer_of(authorization: str) -> str | None:
    """Return the token of an ``Authorization`` header, if it has one."""
    scheme, _, token = authorization.partition(" ")
    return token.strip() or None if scheme.lower() == "bearer" else None


async def authenticate(connection: HTTPConnection, accounts: Accounts) -> User:
    """Return the user of a connection; ``NotAuthenticated`` if the token is missing, unknown or expired."""
    connection.state.user = user = await accounts.authenticate(token_of(connection))
    return user
