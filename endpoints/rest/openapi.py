"""OpenAPI document: the problems of each operation and their examples; the Swagger UI that shows it."""

import asyncio
from importlib.resources import as_file, files
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.openapi.utils import get_openapi
from fastapi.responses import HTMLResponse
from fastapi.routing import APIRoute
from fastapi.staticfiles import StaticFiles
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from endpoints.http.problems import MEDIA_TYPE, TYPE
from endpoints.rest.schemas import Problem

Responses = dict[int | str, dict[str, Any]]

DOCUMENT = "/openapi.json"
"""Path of the OpenAPI document."""

_SCHEMAS = "#/components/schemas/{model}"

TAGS = [
    {"name": "tokens", "description": "Log in and out."},
    {"name": "users", "description": "Users of the cloud."},
    {"name": "groups", "description": "Groups of users, with which robots are shared."},
    {"name": "maps", "description": "Maps, their versions and their files."},
    {
        "name": "buildings",
        "description": "Buildings: floors, which are maps, with their lifts, doors and ways.",
    },
    {"name": "people", "description": "People whom the caller's robots see on a map."},
    {"name": "traffic", "description": "Traffic of the caller's robots on a map: what each holds, and waits for."},
    {"name": "tasks", "description": "Tasks on a map, each for any of the caller's robots that can do it."},
    {"name": "robots", "description": "The caller's robots, and those that are shared with the caller."},
    {"name": "stops", "description": "Stops of robots, which hold until they are released."},
    {"name": "plans", "description": "Path requests and stored paths."},
    {"name": "models", "description": "Robot models that robot files may name."},
    {"name": "planners", "description": "Planners that robot files and path requests may name."},
    {"name": "machines", "description": "Machines of the cloud, for administrators."},
    {"name": "endpoints", "description": "Processes that serve robots, operators and REST, for administrators."},
    {"name": "health", "description": "State of this endpoint, the master, the stores, the disk and the audit log."},
    {"name": "alerts", "description": "Alerts that somebody has acknowledged."},
    {"name": "audit", "description": "Audit log of changes and refusals, for administrators."},
    {"name": "retention", "description": "For how long data are kept, for administrators."},
    {"name": "webhooks", "description": "The caller's webhooks, to which events are sent, and their deliveries."},
    {"name": "containers", "description": "Running containers: the caller's own, or all for an administrator."},
]


_EXAMPLES = {
    400: ("malformed-message", "Malformed message", "the body is not JSON: Expecting value: line 1 column 1 (char 0)"),
    401: ("not-authenticated", "Not authenticated", "the token is unknown or expired: log in again"),
    403: ("not-permitted", "Not permitted", "only an administrator may do this"),
    404: ("not-found", "Not found", "unknown map 'office'"),
    408: ("request-timeout", "Request Timeout", "the body did not arrive within 30 s: send it again, faster"),
    409: ("conflict", "Conflict", "robot 'tb1' is connected: disconnect it first"),
    413: ("message-too-large", "Too large", "the body of this request must have at most 1048576 bytes"),
    415: (
        "unsupported-media-type",
        "Unsupported Media Type",
        "send JSON with the header 'Content-Type: application/json'",
    ),
    416: ("range-not-satisfiable", "Range not satisfiable", "the file has 1048576 bytes: ask for a range within it"),
    422: ("invalid-request", "Invalid request", "body.cores: Input should be greater than 0"),
    429: ("quota-exceeded", "Quota exceeded", "user 'ann' may have 64 containers"),
    500: ("internal-error", "Internal error", "the cloud failed: see its log"),
    503: ("unavailable", "Unavailable", "the disk is full: free space"),
}
_FAULTS = [{"where": ["body", "cores"], "what": "Input should be greater than 0"}]


def problems(*statuses: int) -> Responses:
    """Return the responses that an operation declares for these HTTP status codes of problems."""
    return {status: _response(status, *_EXAMPLES[status]) for status in statuses}


def _response(status: int, slug: str, title: str, detail: str) -> dict[str, Any]:
    example: dict[str, Any] = {"type": TYPE + slug, "title": title, "status": status, "detail": detail}
    if slug == "invalid-request":
        example["errors"] = _FAULTS
    schema = {"$ref": _SCHEMAS.format(model="Problem")}
    return {"description": title, "content": {MEDIA_TYPE: {"schema": schema, "example": example}}}


EVERYWHERE = problems(422, 500, 503)
KNOWN = problems(401)
"""Responses of operations that need a token."""

ADMIN = problems(401, 403)
"""Responses of operations for administrators."""

BODY = problems(400, 408, 413, 415)
"""Responses of operations with a body."""


def operation_id(route: APIRoute) -> str:
    """Return the id of an operation: the name of its function."""
    return route.name


def describe(app: FastAPI) -> None:
    """Serve the OpenAPI document of an application, with the schema of problems, in place of FastAPI's own route.

    It takes one to two seconds to make, so a thread makes it when it is first asked for: on the event loop, all robots
    of the endpoint would wait, and on a busy computer the master would take the endpoint for frozen.
    """
    making = asyncio.Lock()

    async def document(_request: Request) -> Response:
        async with making:
            described = app.openapi_schema or await run_in_threadpool(app.openapi)
        return JSONResponse(described)

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            described = get_openapi(
                title=app.title,
                version=app.version,
                summary=app.summary,
                description=app.description,
                routes=app.routes,
                tags=app.openapi_tags,
                servers=app.servers,
            )
            problem = Problem.model_json_schema(ref_template=_SCHEMAS)
            described["components"]["schemas"] |= {**problem.pop("$defs"), "Problem": problem}
            app.openapi_schema = described
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]
    app.add_route(DOCUMENT, document, include_in_schema=False)


# Swagger UI of the REST service, served without files from the internet, which labs often cannot reach.
#
# Its links are relative, so it also works below a path of a proxy.

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
