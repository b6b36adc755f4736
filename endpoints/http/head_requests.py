"""HEAD for every resource that has GET (RFC 9110, section 9.1)."""

from starlette.types import ASGIApp, Message, Receive, Scope, Send


class HeadRequests:
    """ASGI middleware that answers HEAD like GET, without the body.

    The server drops the body of the answer. A body that is sent in parts is not read to its end: after the first part,
    the application receives the message that the client has disconnected.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] == "http" and scope["method"] == "HEAD":
            head = _Head(receive, send)
            await self._app({**scope, "method": "GET"}, head.receive, head.send)
        else:
            await self._app(scope, receive, send)


class _Head:
    """Answer to one HEAD request."""

    def __init__(self, receive: Receive, send: Send) -> None:
        self._receive = receive
        self._send = send
        self._complete = False

    async def receive(self) -> Message:
        return {"type": "http.disconnect"} if self._complete else await self._receive()

    async def send(self, message: Message) -> None:
        if self._complete:
            return
        if message["type"] == "http.response.body":
            self._complete = True
            message = {"type": "http.response.body", "body": b"", "more_body": False}
        await self._send(message)
