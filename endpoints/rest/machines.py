"""Machines of the cloud, for administrators."""

from fastapi import APIRouter

from endpoints.rest.dependencies import Admin, Provided
from endpoints.rest.schemas import MachineAnswer
from engine.views import MachineView

router = APIRouter(prefix="/machines", tags=["machines"])


@router.get("", response_model=list[MachineAnswer])
async def list_machines(services: Provided, _admin: Admin) -> list[MachineView]:
    """List all machines."""
    return services.cloud.machines()
