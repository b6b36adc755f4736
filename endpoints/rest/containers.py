"""Containers: the caller's own, or all for an administrator."""

from fastapi import APIRouter

from endpoints.rest.dependencies import Caller, Provided
from endpoints.rest.schemas import ContainerAnswer
from engine.views import ContainerView

router = APIRouter(prefix="/containers", tags=["containers"])


@router.get("", response_model=list[ContainerAnswer])
async def list_containers(services: Provided, user: Caller) -> list[ContainerView]:
    """List the caller's containers; all, if an administrator asks."""
    return services.cloud.containers(None if user.role == "admin" else user.id)
