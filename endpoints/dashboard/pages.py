"""Static files of the dashboard, and their security headers. All links are relative, as a proxy may add a path.

The pages get all data from the REST service and the robot WebSocket, with the token of the user who logged in. The
server holds no state for them and draws nothing.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar, Final

from fastapi import FastAPI
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import RedirectResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from endpoints.http.front import prefix_of

PATH: Final = "/dashboard"
FOLDER: Final = Path(__file__).parent / "static"

POLICY: Final = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self'",
        "connect-src 'self'",  # REST, and WebSockets of the same host
        "base-uri 'none'",
        "form-action 'none'",  # if the script fails to load, no form can send a password
        "frame-ancestors 'none'",
        "require-trusted-types-for 'script'",  # no text can become HTML, such as the name of a robot
        "trusted-types 'none'",
    )
)
"""Content-Security-Policy: only files and connections of this cloud, and no HTML from text."""

HEADERS: Final = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    # Revalidated each time by ETag: a new version is seen at once, an unchanged file costs a 304.
    "Cache-Control": "no-cache",
}


class Pages(StaticFiles):
    """Static files of one folder with the security headers."""

    headers: ClassVar[Mapping[str, str]] = HEADERS

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Return a file, or 304 if it did not change."""
        response = await super().get_response(path, scope)
        response.headers.update(self.headers)
        return response


def add_dashboard(app: FastAPI) -> None:
    """Serve the dashboard, and redirect browsers from the root to it."""
    app.add_api_route("/", _root, include_in_schema=False)
    app.add_api_route(PATH, _to_dashboard, include_in_schema=False)
    app.mount(PATH, Pages(directory=FOLDER, html=True), name="dashboard")


async def _root(request: Request) -> Response:
    # Robots open their WebSocket at this path; an HTTP client that accepts HTML is a browser.
    if "text/html" not in request.headers.get("accept", ""):
        raise HTTPException(
            404,
            "only the robots' WebSocket is here, and this request has no 'Upgrade: websocket', which a proxy must "
            "forward; the REST service is under /v1, see /docs",
        )
    return await _to_dashboard(request)


async def _to_dashboard(request: Request) -> Response:
    return to_folder(request, PATH)


def to_folder(request: Request, path: str) -> Response:
    """Return the redirect to the folder at a path of the root, also below the path of a proxy."""
    prefix = prefix_of(request.scope)
    return RedirectResponse(f"{prefix}{path}/" if prefix else f"{path.removeprefix('/')}/")
