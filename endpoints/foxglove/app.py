"""Application for viewers: the WebSocket, and a page that explains how to open it."""

from dataclasses import replace
from typing import ClassVar

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket

from endpoints.audit.requests import AuditedRequests
from endpoints.foxglove.viewer_socket import serve_viewer_socket
from endpoints.foxglove.viewers import Viewers
from endpoints.http.front import front
from endpoints.http.front_settings import ANY_ORIGIN, FrontSettings
from endpoints.protocols import ClientProtocol
from endpoints.rosbridge.session_registry import SessionRegistry
from endpoints.services.services import Services

MAX_FRAME = 1024 * 1024
"""Largest frame of a viewer [bytes], which publishes goals, not sensors."""


class Foxglove(ClientProtocol):
    """Foxglove's WebSocket protocol; needs the extra ``foxglove``."""

    max_frame: ClassVar[int] = MAX_FRAME

    def app(self) -> ASGIApp:
        """Return the application."""
        return foxglove_app(self._services, self._sessions, self._settings)


def foxglove_app(services: Services, sessions: SessionRegistry, settings: FrontSettings) -> ASGIApp:
    """Return the application; its address is ``/``.

    Parameters
    ----------
    services : Services
        Services with the accounts, the store and the audit log.
    sessions : SessionRegistry
        Attaches to the places of robots.
    settings : FrontSettings
        Trusted proxies.
    """
    viewers = Viewers(services, sessions)

    async def viewer_socket(websocket: WebSocket) -> None:
        await serve_viewer_socket(websocket, services, viewers)

    app = Starlette(
        routes=[Route("/", _page, methods=["GET"]), WebSocketRoute("/", viewer_socket)],
        middleware=[Middleware(AuditedRequests, log=services.audit)],
    )
    # Foxglove's own pages are of other hosts, and send no cookies: the token in the address is the right to connect.
    return front(app, replace(settings, allowed_origins=(ANY_ORIGIN,)), private="/v1")


async def _page(request: Request) -> Response:
    scheme = "wss" if request.url.scheme == "https" else "ws"
    address = f"{scheme}://{request.url.netloc}/?token=TOKEN"
    return PlainTextResponse(f"Open a connection in Foxglove: Foxglove WebSocket, {address}\n")
