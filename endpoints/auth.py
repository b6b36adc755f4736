"""Who asks: the token of a request or a WebSocket handshake, and its user."""

from starlette.requests import HTTPConnection

from endpoints.accounts import Accounts
from ppaas.errors import NotAuthenticated
from storage.records import User


def token_of(connection: HTTPConnection) -> str:
    """Return the bearer token of a header, else of the query.

    Raises
    ------
    NotAuthenticated
        There is none.
    """
    scheme, _, token = connection.headers.get("authorization", "").partition(" ")
    if scheme.lower() != "bearer":
        token = connection.query_params.get("token", "")
    if not token.strip():
        raise NotAuthenticated("no token: log in with POST /v1/tokens and send it as 'Authorization: Bearer TOKEN'")
    return token.strip()


async def authenticate(connection: HTTPConnection, accounts: Accounts) -> User:
    """Return the user who asks; ``NotAuthenticated`` if the token is missing, unknown or expired."""
    return await accounts.authenticate(token_of(connection))
