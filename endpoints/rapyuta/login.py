"""Login of robots: by the SHA-256 hash of a separate password, where an administrator allows it, or by a token."""

from starlette.websockets import WebSocket

from endpoints.accounts.authentication import address_of, authenticate_socket
from endpoints.accounts.caller import note_caller
from endpoints.audit.notes import note_details, note_object
from endpoints.rapyuta.robot import Identity
from endpoints.rest.dependencies import check_unscoped
from endpoints.services.services import Services
from ppaas.errors import NotAuthenticated, NotPermitted, TooManyAttempts
from ppaas.wire.rapyuta.handshake import Login, is_digest
from storage.records import User

UNKNOWN = "(unknown)"
"""Name of all users who do not exist, in the audit log."""


async def log_in(socket: WebSocket, login: Login, services: Services) -> tuple[User, Identity]:
    """Return the user of a robot, and its login; note both for the audit log.

    A robot whose secret is a hash is logged in by the password that an administrator has set for this protocol, any
    other by a token, which is in the header ``Authorization`` or ``token`` of the query.

    Raises
    ------
    NotAuthenticated
        The user does not exist, may not log in so, or the password or the token is wrong.
    TooManyAttempts
        Too many logins of this user or from this address failed.
    """
    note_object(socket.scope, f"robots/{login.robot}")
    note_details(socket.scope, protocol="rapyuta")
    if is_digest(login.password) and not _has_token(socket):
        return await _by_digest(socket, login, services)
    user, token = await authenticate_socket(socket, services.accounts)
    if user.id != login.user:
        raise NotAuthenticated("the token is not one of the user in userID")
    check_unscoped(user)
    return user, Identity(user.id, token)


async def _by_digest(socket: WebSocket, login: Login, services: Services) -> tuple[User, Identity]:
    try:
        user, token = await services.accounts.rapyuta.sign_in(login.user, login.password, address_of(socket))
    except (NotAuthenticated, TooManyAttempts):
        known = await services.accounts.is_known(login.user)
        note_details(socket.scope, login=login.user if known else UNKNOWN)
        raise
    note_caller(socket.scope, user.id, token)
    return user, Identity(user.id, token, user.rapyuta_hash)


async def check_verifier(identity: Identity, services: Services) -> None:
    """Raise unless the password by which a robot logged in is still the one for this protocol.

    Raises
    ------
    NotPermitted
        An administrator has changed or removed it.
    """
    if not identity.verifier:
        return
    user = await services.accounts.user_of(identity.token)
    if user.rapyuta_hash != identity.verifier:
        raise NotPermitted("the password of this user for robots of Rapyuta was changed or removed")


def _has_token(socket: WebSocket) -> bool:
    return bool(socket.headers.get("authorization") or socket.query_params.get("token"))
