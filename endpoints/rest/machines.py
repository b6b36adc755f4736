"""Machines of the cloud, for administrators."""

from fastapi import APIRouter

from endpoints.rest.dependencies import Admin, Paged, Provided
from endpoints.rest.names import MachineId
from endpoints.rest.openapi import ADMIN, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import MachineAnswer
from engine.views import MachineView
from ppaas.errors import NotFound

router = APIRouter(prefix="/machines", tags=["machines"])


@router.get("", response_model=Page[MachineAnswer], responses=ADMIN)
async def list_machines(services: Provided, _admin: Admin, paging: Paged) -> dict[str, object]:
    """List all machines by id."""
    after = paging.key(str, "")
    machines = sorted(services.cloud.machines(), key=lambda machine: machine.id)
    return paging.page([machine for machine in machines if machine.id > after], lambda machine: machine.id)


@router.get("/{machine_id}", response_model=MachineAnswer, responses=ADMIN | problems(404))
async def show_machine(machine_id: MachineId, services: Provided, _admin: Admin) -> MachineView:
    """Show a machine."""
    known = {machine.id: machine for machine in services.cloud.machines()}
    if machine_id not in known:
        raise NotFound("machine", machine_id, list(known))
    return known[machine_id]
