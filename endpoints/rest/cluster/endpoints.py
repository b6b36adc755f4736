"""Routes of the cloud's endpoints, for administrators."""

from fastapi import APIRouter

from endpoints.rest.cluster.schemas import EndpointAnswer
from endpoints.rest.dependencies import Admin, Paged, Provided
from endpoints.rest.names import EndpointId
from endpoints.rest.openapi import ADMIN, problems
from endpoints.rest.paging import Page
from engine.control.views import EndpointView
from ppaas.errors import NotFound

router = APIRouter(prefix="/endpoints", tags=["endpoints"])


@router.get("", response_model=Page[EndpointAnswer], responses=ADMIN)
async def list_endpoints(services: Provided, _admin: Admin, paging: Paged) -> dict[str, object]:
    """List the endpoints of the cloud by id, with their load: the processes that serve robots, operators and REST.

    An endpoint that was lost is not listed any more.
    """
    after = paging.key(str, "")
    endpoints = sorted(await services.cloud.endpoints.views(), key=lambda endpoint: endpoint.id)
    return paging.page([endpoint for endpoint in endpoints if endpoint.id > after], lambda endpoint: endpoint.id)


@router.get("/{endpoint_id}", response_model=EndpointAnswer, responses=ADMIN | problems(404))
async def show_endpoint(endpoint_id: EndpointId, services: Provided, _admin: Admin) -> EndpointView:
    """Show an endpoint and its load."""
    known = {endpoint.id: endpoint for endpoint in await services.cloud.endpoints.views()}
    if endpoint_id not in known:
        raise NotFound("endpoint", endpoint_id, list(known))
    return known[endpoint_id]
