"""Closing of WebSockets by the cloud, with the reason."""

import asyncio
import contextlib

from starlette.websockets import WebSocket, WebSocketDisconnect

from ppaas.errors import NotAuthenticated, NotPermitted, PPaaSError

CLOSED_BY_CLOUD = 1011
"""Close code: the session is over."""

NO_RIGHT = 1008
"""Close code: the client lost a right, such as its token (policy violation, RFC 6455, section 7.4.1)."""

CLOSE_TIMEOUT = 2.0
"""Time limit of the closing handshake [s]."""

MAX_REASON = 123
"""Largest reason in a close frame [bytes] (RFC 6455, section 5.5)."""


async def close_with(socket: WebSocket, error: PPaaSError, code: int | None = None, *, last: bytes = b"") -> None:
    """Close a WebSocket because of an error; a client that does not take part is left.

    Parameters
    ----------
    socket : WebSocket
        Accepted WebSocket.
    error : PPaaSError
        Reason.
    code : int, optional
        Close code; default: `NO_RIGHT` for a lost right, `CLOSED_BY_CLOUD` for all else.
    last : bytes
        Text that is sent before it; empty for none.
    """
    if code is None:
        code = NO_RIGHT if isinstance(error, NotAuthenticated | NotPermitted) else CLOSED_BY_CLOUD
    reason = f"{error.slug}: {error.public}".encode()[:MAX_REASON].decode(errors="ignore")
    with contextlib.suppress(TimeoutError, WebSocketDisconnect):
        async with asyncio.timeout(CLOSE_TIMEOUT):
            if last:
                await socket.send_text(last.decode())
            await socket.close(code, reason)
