"""Routes of containers: of the caller's robots and of shared robots, or all for an administrator."""

from contextlib import suppress
from typing import Annotated

from fastapi import APIRouter, Body
from starlette.concurrency import run_in_threadpool

from endpoints.resources.services import Services
from endpoints.rest.cluster.schemas import ContainerAnswer
from endpoints.rest.dependencies import Caller, Paged, Provided
from endpoints.rest.names import ContainerId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import Cores, RequestBody
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute
from endpoints.sharing.shared_robots import reach, robots_shared_with
from engine.control.views import ContainerView
from ppaas.errors import NotFound, Unavailable
from storage.records import User
from storage.sharing_records import ShareRole

router = APIRouter(prefix="/containers", tags=["containers"], route_class=StrictRoute)


class ContainerChange(RequestBody):
    """Changes of a running container."""

    cores: Cores


@router.get("", response_model=Page[ContainerAnswer], responses=KNOWN)
async def list_containers(services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the containers of the caller and of shared robots, or all for an administrator, oldest first."""
    after = _age(paging.key(str, ""))
    visible = await _visible(services, user)
    containers = sorted(visible, key=lambda container: _age(container.id))
    return paging.page([one for one in containers if _age(one.id) > after], lambda container: container.id)


@router.get("/{container_id}", response_model=ContainerAnswer, responses=KNOWN | problems(404))
async def show_container(container_id: ContainerId, services: Provided, user: Caller) -> ContainerView:
    """Show a container."""
    return await _found(services, user, container_id, "look")


@router.delete("/{container_id}", status_code=202, responses=KNOWN | problems(403, 404))
async def give_up_container(container_id: ContainerId, services: Provided, user: Caller) -> None:
    """End a container at once, as if it had died; another container replaces it.

    The robot stays connected and its clone continues from the last checkpoint. It counts as a death: a place whose
    containers die too often is closed. To disconnect a robot, close its sockets instead.
    """
    await _found(services, user, container_id, "administer")
    await services.cloud.containers.give_up(container_id)


@router.patch("/{container_id}", response_model=ContainerAnswer, responses=KNOWN | BODY | problems(403, 404, 429))
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
    container = await _found(services, user, container_id, "administer")
    if change.cores != container.cores:
        await services.cloud.containers.resize(container_id, change.cores)
    return await show_container(container_id, services, user)


async def _found(services: Services, user: User, container_id: str, role: ShareRole) -> ContainerView:
    """Return a container; `NotFound` unless it is the caller's, or of a robot on which the caller has a role.

    Raises
    ------
    NotPermitted
        The caller may see it, and has a lesser role on its robot.
    """
    for container in await _visible(services, user):
        if container.id == container_id:
            if role != "look" and container.user != user.id and user.role != "admin":
                robot = await run_in_threadpool(reach, services.store, user, f"{container.user}:{container.robot}")
                robot.access.check_role(role)
            return container
    raise NotFound("container", container_id)


async def _visible(services: Services, user: User) -> list[ContainerView]:
    if user.role == "admin":
        return await services.cloud.containers.views(None)
    found = list(await services.cloud.containers.views(user.id))
    with suppress(Unavailable):  # the caller's own are shown without the store
        robots = await run_in_threadpool(robots_shared_with, services.store, user)
        shared = {(robot.user, robot.id) for robot in robots}
        for owner in {owner for owner, _ in shared}:
            found += [one for one in await services.cloud.containers.views(owner) if (owner, one.robot) in shared]
    return found


def _age(container: str) -> tuple[int, str]:
    """Return a sort key that orders ids as they were assigned: c2 before c10."""
    return len(container), container
