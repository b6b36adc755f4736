"""The application: the REST service, to which the robot WebSocket is added."""

from importlib.metadata import version

from fastapi import FastAPI

from endpoints.body_limit import BodyLimit, BodyLimits
from endpoints.dashboard.pages import add_dashboard
from endpoints.problems import add_problem_handlers
from endpoints.rest import (
    containers,
    kept_plans,
    machines,
    map_cells,
    map_versions,
    maps,
    models,
    planning,
    plans,
    robots,
    tokens,
    users,
)
from endpoints.rest.openapi import EVERYWHERE, TAGS, describe, operation_id
from endpoints.services import Services

PREFIX = "/v1"

DESCRIPTION = """
Path planning as a service. Log in with `POST /v1/tokens`, publish a map with `POST /v1/maps`, and ask for a path with
`POST /v1/maps/{map_id}/plans`. A robot registers with `PUT /v1/robots/{robot_id}` and then opens a WebSocket at
`/?robot=ID&token=TOKEN`, speaking rosbridge.

Lists come in pages: `limit` items, and in `next` the `cursor` of the following page, or null.

Lengths are metres, angles radians, times seconds. Every error is a problem of RFC 9457 whose `type` is stable.
"""

RESOURCES = (
    planning,
    tokens,
    users,
    maps,
    map_versions,
    map_cells,
    models,
    robots,
    plans,
    kept_plans,
    machines,
    containers,
)


def create_app(services: Services) -> FastAPI:
    """Return the application that serves these services; it starts and ends nothing of them."""
    app = FastAPI(
        title="PPaaS",
        summary="Path Planning as a Service",
        description=DESCRIPTION,
        version=version("ppaas"),
        responses=EVERYWHERE,
        openapi_tags=TAGS,
        generate_unique_id_function=operation_id,
        redirect_slashes=False,
    )
    describe(app)
    app.state.services = services
    for resource in RESOURCES:
        app.include_router(resource.router, prefix=PREFIX)
    settings = services.settings
    uploads = {f"{PREFIX}{maps.router.prefix}": BodyLimits(settings.max_upload, settings.max_upload_seconds)}
    app.add_middleware(planning.DirectPlans, prefix=PREFIX, services=services)
    app.add_middleware(BodyLimit, limits=BodyLimits(settings.max_body, settings.max_body_seconds), uploads=uploads)
    add_problem_handlers(app)
    add_dashboard(app)
    return app
