"""Routes of containers: the caller's own, or all for an administrator."""

from typing import Annotated

from fastapi import APIRouter, Body

from endpoints.rest.cluster.schemas import ContainerAnswer
from endpoints.rest.dependencies import Caller, Paged, Provided
from endpoints.rest.names import ContainerId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import Cores, RequestBody
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute
from endpoints.services.services import Services
from engine.service.views import ContainerView
from ppaas.errors import NotFound
from storage.records import User

router = APIRouter(prefix="/containers", tags=["containers"], route_class=StrictRoute)


class ContainerChange(RequestBody):
    """Changes of a running container."""

    cores: Cores


@router.get("", response_model=Page[ContainerAnswer], responses=KNOWN)
async def list_containers(services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the caller's containers, or all for an administrator, oldest first."""
    after = _age(paging.key(str, ""))
    containers = sorted(_visible(services, user), key=lambda container: _age(container.id))
    return paging.page([one for one in containers if _age(one.id) > after], lambda container: container.id)


@router.get("/{container_id}", response_model=ContainerAnswer, responses=KNOWN | problems(404))
async def show_container(container_id: ContainerId, services: Provided, user: Caller) -> ContainerView:
    """Show a container."""
    for container in _visible(services, user):
        if container.id == container_id:
            return container
    raise NotFound("container", container_id)


@router.delete("/{container_id}", status_code=202, responses=KNOWN | problems(404))
async def give_up_container(container_id: ContainerId, services: Provided, user: Caller) -> None:
    """End a container at once, as if it had died; another container replaces it.

    The robot stays connected and its clone continues from the last checkpoint. It counts as a death: a place whose
    containers die too often is closed. To disconnect a robot, close its sockets instead.
    """
    await show_container(container_id, services, user)
    services.cloud.give_up_container(container_id)


@router.patch("/{container_id}", response_model=ContainerAnswer, responses=KNOWN | BODY | problems(404, 429))
async def resize_container(
    container_id: ContainerId,
    change: Annotated[ContainerChange, Body(media_type=MERGE_PATCH)],
    services: Provided,
    user: Caller,
) -> ContainerView:
    """Resize a running container: its CPUs, the threads of its kernels and all that depends on its size.

    Its clone keeps running. If the container dies, its replacement has the new size too; a robot that connects again
    gets the size in its file.
    """
    container = await show_container(container_id, services, user)
    if change.cores != container.cores:
        services.cloud.resize_container(container_id, change.cores)
    return await show_container(container_id, services, user)


def _visible(services: Services, user: User) -> list[ContainerView]:
    return services.cloud.containers(None if user.role == "admin" else user.id)


def _age(container: str) -> tuple[int, str]:
    """Return a sort key that orders ids as they were assigned: c2 before c10."""
    return len(container), container
