"""Routes of the cloud's machines, for administrators."""

from typing import Annotated, Any

import msgspec
from fastapi import APIRouter, Body, Query

from endpoints.resources.services import Services
from endpoints.rest.cluster.schemas import AdmittedMachine, MachineAnswer, MachineChange
from endpoints.rest.dependencies import Admin, Paged, Provided
from endpoints.rest.names import MachineId
from endpoints.rest.openapi import ADMIN, BODY, problems
from endpoints.rest.paging import Page
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute, merge
from engine.control.views import MachineView
from engine.specs.machine_settings import MachineSettings
from ppaas.decoding import converted
from ppaas.errors import NotFound

router = APIRouter(prefix="/machines", tags=["machines"], route_class=StrictRoute)


@router.get("", response_model=Page[MachineAnswer], responses=ADMIN)
async def list_machines(services: Provided, _admin: Admin, paging: Paged) -> dict[str, object]:
    """List all machines by id."""
    after = paging.key(str, "")
    machines = sorted(await services.cloud.machines.views(), key=lambda machine: machine.id)
    return paging.page([machine for machine in machines if machine.id > after], lambda machine: machine.id)


@router.get("/{machine_id}", response_model=MachineAnswer, responses=ADMIN | problems(404))
async def show_machine(machine_id: MachineId, services: Provided, _admin: Admin) -> MachineView:
    """Show a machine."""
    return await _machine(services, machine_id)


@router.patch("/{machine_id}", response_model=MachineAnswer, responses=ADMIN | BODY | problems(404))
async def change_machine(
    machine_id: MachineId,
    change: Annotated[MachineChange, Body(media_type=MERGE_PATCH)],
    services: Provided,
    _admin: Admin,
) -> MachineView:
    """Change labels and limits of a machine, or drain it, by a JSON merge patch (RFC 7396).

    Running containers stay, also if they exceed the new limits. The clones of a draining machine move one by one to
    machines with free capacity; their robots stay connected. The settings are stored, also while the machine is
    disconnected.
    """
    before = await services.cloud.machines.settings(machine_id)
    await services.cloud.machines.configure(machine_id, _merge_settings(before, change.model_dump(exclude_unset=True)))
    return await _machine(services, machine_id)


@router.delete("/{machine_id}", status_code=204, responses=ADMIN | problems(404, 409))
async def remove_machine(
    machine_id: MachineId,
    services: Provided,
    _admin: Admin,
    force: Annotated[
        bool, Query(description="Remove it even if it runs containers: they are lost and started elsewhere")
    ] = False,
) -> None:
    """Remove a machine; it cannot join again until it is admitted. Refused (409) if it runs containers: drain it first.

    Its settings are forgotten.
    """
    await services.cloud.machines.remove(machine_id, force=force)


@router.post("/{machine_id}/admit", response_model=AdmittedMachine, responses=ADMIN)
async def admit_machine(machine_id: MachineId, services: Provided, _admin: Admin) -> AdmittedMachine:
    """Admit a removed machine: it joins again when its agent is started."""
    await services.cloud.machines.admit(machine_id)
    return AdmittedMachine(id=machine_id)


async def _machine(services: Services, machine_id: str) -> MachineView:
    known = {machine.id: machine for machine in await services.cloud.machines.views()}
    if machine_id not in known:
        raise NotFound("machine", machine_id, list(known))
    return known[machine_id]


def _merge_settings(before: MachineSettings, change: dict[str, Any]) -> MachineSettings:
    return converted(merge(msgspec.to_builtins(before), change), MachineSettings)
