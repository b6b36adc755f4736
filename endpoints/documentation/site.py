"""Files of the documentation site, with the security headers of the dashboard.

The wheel does not contain the site: an endpoint serves a folder, by default the one that ``make docs`` makes in a
checkout.
"""

from pathlib import Path
from typing import ClassVar, Final

from fastapi import FastAPI
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from endpoints.dashboard.pages import HEADERS, Pages, to_folder

PATH: Final = "/docs-site"

BUILT: Final = Path(__file__).parents[2] / "build" / "docs"
"""Folder of the site in a checkout."""

POLICY: Final = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self' 'unsafe-inline'",  # colours of the theme, and diagrams
        "img-src 'self' data:",  # icons of the theme
        "connect-src 'self'",  # the search shows parts of the pages that it finds
        "base-uri 'none'",
        "form-action 'self'",  # the search
        "frame-ancestors 'none'",
    )
)
"""Content-Security-Policy: only files of this cloud, and no script within a page."""


class SitePages(Pages):
    """Files of the site; while it is not built, the answer says how to build it.

    Parameters
    ----------
    folder : Path
        Folder of the site; it may be built later.
    """

    headers: ClassVar = {**HEADERS, "Content-Security-Policy": POLICY}

    def __init__(self, folder: Path) -> None:
        super().__init__(directory=folder, html=True, check_dir=False)
        self._index = folder / "index.html"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a file."""
        if not self._index.is_file():
            raise HTTPException(
                404,
                "this cloud has no documentation site: build it with 'make docs' in a checkout of ppaas, or give its "
                "folder to 'ppaas up --docs-site'",
            )
        await super().__call__(scope, receive, send)


def add_documentation(app: FastAPI, folder: Path) -> None:
    """Serve the documentation site from a folder."""
    app.add_api_route(PATH, _to_site, include_in_schema=False)
    app.mount(PATH, SitePages(folder), name="documentation")


async def _to_site(request: Request) -> Response:
    return to_folder(request, PATH)
