"""Application for robots of Rapyuta: the master's page with the address, and the WebSocket."""

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket

from endpoints.audit.requests import AuditedRequests
from endpoints.http.front import front
from endpoints.http.front_settings import FrontSettings
from endpoints.protocols import ClientProtocol
from endpoints.rapyuta.registry import RobotRegistry
from endpoints.rapyuta.robot_socket import FATAL, serve_robot_socket
from endpoints.rosbridge.session_registry import SessionRegistry
from endpoints.services.services import Services
from ppaas.wire.rapyuta.handshake import answer_master


class Rapyuta(ClientProtocol):
    """Protocol of 2013."""

    def __init__(self, services: Services, sessions: SessionRegistry, settings: FrontSettings) -> None:
        super().__init__(services, sessions, settings)
        self._registry = RobotRegistry(services, sessions)

    def app(self) -> ASGIApp:
        """Return the application."""
        return rapyuta_app(self._services, self._registry, self._settings)

    async def watch(self) -> None:
        """Check periodically whether robots may still be logged in."""
        await self._registry.watch()

    async def close(self) -> None:
        """End all robots."""
        await self._registry.close()


def rapyuta_app(services: Services, registry: RobotRegistry, settings: FrontSettings) -> ASGIApp:
    """Return the application; its address is ``/`` for both.

    Parameters
    ----------
    services : Services
        Services with the accounts, the store and the audit log.
    registry : RobotRegistry
        Registry of the robots.
    settings : FrontSettings
        Trusted proxies, which may state the address by which robots come.
    """

    async def robot_socket(websocket: WebSocket) -> None:
        await serve_robot_socket(websocket, services, registry)

    app = Starlette(
        routes=[Route("/", _master, methods=["GET"]), WebSocketRoute("/", robot_socket)],
        middleware=[Middleware(AuditedRequests, log=services.audit)],
        exception_handlers={Exception: _fault},
    )
    return front(app, settings, private="/v1")


async def _master(request: Request) -> Response:
    """Return the address of the WebSocket: the address of this request, which the robot has reached."""
    scheme = "wss" if request.url.scheme == "https" else "ws"
    answer = answer_master(request.query_params.multi_items(), f"{scheme}://{request.url.netloc}/")
    return Response(answer.body, answer.status, {"Cache-Control": "no-store"}, answer.media_type)


async def _fault(_request: Request, _error: Exception) -> Response:
    return PlainTextResponse(FATAL, 500)
