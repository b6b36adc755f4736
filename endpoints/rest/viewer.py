"""Swagger UI of the REST service, served without files from the internet, which labs often cannot reach.

Its links are relative, so it also works below a path of a proxy.
"""

from importlib.resources import as_file, files

from fastapi import FastAPI
from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.responses import HTMLResponse
from fastapi.staticfiles import StaticFiles

from endpoints.rest.openapi import DOCUMENT

PAGE = "/docs"
FILES = "/docs/viewer"


def add_viewer(app: FastAPI) -> None:
    """Serve the page and its files."""
    with as_file(files("fastapi_offline") / "static") as folder:
        app.mount(FILES, StaticFiles(directory=folder))

    @app.get(PAGE, include_in_schema=False)
    async def show() -> HTMLResponse:
        folder = FILES.removeprefix("/")
        return get_swagger_ui_html(
            openapi_url=DOCUMENT.removeprefix("/"),
            title=app.title,
            swagger_js_url=f"{folder}/swagger-ui-bundle.js",
            swagger_css_url=f"{folder}/swagger-ui.css",
            swagger_favicon_url=f"{folder}/favicon.png",
        )
