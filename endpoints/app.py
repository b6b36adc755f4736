"""The application: the REST service, to which the robot WebSocket is added."""

from importlib.metadata import version
from typing import Any

from fastapi import FastAPI

from endpoints.body_limit import BodyLimit
from endpoints.problems import MEDIA_TYPE, add_problem_handlers
from endpoints.rest import containers, machines, maps, plans, robots, tokens, users
from endpoints.rest.schemas import Problem
from endpoints.services import Services

PREFIX = "/v1"

DESCRIPTION = """
Path planning as a service. Log in with `POST /v1/tokens`, publish a map with `POST /v1/maps`, and ask for a path with
`POST /v1/maps/{map_id}/plans`. A robot registers with `PUT /v1/robots/{robot_id}` and then opens a WebSocket at
`/?robot=ID&token=TOKEN`, speaking rosbridge.

Lengths are metres, angles radians, times seconds. Every error is a problem of RFC 9457 whose `type` is stable.
"""

_PROBLEM: dict[int | str, dict[str, Any]] = {
    "default": {
        "description": "A problem (RFC 9457)",
        "content": {MEDIA_TYPE: {"schema": Problem.model_json_schema()}},
    }
}


def create_app(services: Services) -> FastAPI:
    """Return the application that serves these services; it starts and ends nothing of them."""
    app = FastAPI(
        title="PPaaS",
        summary="Path Planning as a Service",
        description=DESCRIPTION,
        version=version("ppaas"),
        responses=_PROBLEM,
    )
    app.state.services = services
    for resource in (tokens, users, maps, robots, plans, machines, containers):
        app.include_router(resource.router, prefix=PREFIX)
    uploads = {f"{PREFIX}{maps.router.prefix}": services.settings.max_upload}
    app.add_middleware(BodyLimit, limit=services.settings.max_body, uploads=uploads)
    add_problem_handlers(app)
    return app
