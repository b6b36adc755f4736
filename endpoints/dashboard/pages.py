"""The dashboard's files, and what a browser may do with them.

The pages are static: all they show they ask of the REST service and the robot WebSocket, with the token of whoever
logged in. So this room holds no state, and nothing of drawing runs in the process that carries robots.
"""

from pathlib import Path
from typing import Final

from fastapi import FastAPI
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import RedirectResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

PATH: Final = "/dashboard"
FOLDER: Final = Path(__file__).parent / "static"

POLICY: Final = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self'",
        "connect-src 'self'",  # REST and, of the same host, WebSockets
        "base-uri 'none'",
        "form-action 'none'",  # were the script not to load, no password would leave in a form
        "frame-ancestors 'none'",
        "require-trusted-types-for 'script'",  # no text can become HTML, whatever a robot is called
        "trusted-types 'none'",
    )
)
"""Content-Security-Policy: our own files, our own cloud, and nothing written into the page as HTML."""

HEADERS: Final = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    # Asked each time and answered 304 by its ETag: a new version is seen at once, an old one costs nothing.
    "Cache-Control": "no-cache",
}


class Pages(StaticFiles):
    """Files of one folder, each with the headers that keep a browser to it."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Return a file, or that it did not change."""
        response = await super().get_response(path, scope)
        response.headers.update(HEADERS)
        return response


def add_dashboard(app: FastAPI) -> None:
    """Serve the dashboard, and lead browsers that ask for nothing to it."""
    app.add_api_route("/", _front_door, include_in_schema=False)
    app.add_api_route(PATH, _to_dashboard, include_in_schema=False)
    app.mount(PATH, Pages(directory=FOLDER, html=True), name="dashboard")


async def _front_door(request: Request) -> Response:
    # Robots open their WebSocket at this path; who comes by HTTP and reads HTML is a person.
    if "text/html" not in request.headers.get("accept", ""):
        raise HTTPException(404, "nothing is here but the robots' WebSocket; the REST service begins at /v1, see /docs")
    return await _to_dashboard()


async def _to_dashboard() -> Response:
    return RedirectResponse(f"{PATH}/")
