"""Facts about robots that are not connected, from the stores, the quotas and the machines."""

from endpoints.rest.dependencies import readable_head
from endpoints.services.robot_facts import RobotFacts
from endpoints.services.services import Services
from ppaas.diagnosis.observations.facts import AbsenceFacts
from ppaas.errors import PPaaSError, QuotaExceeded
from ppaas.maps.new_map import new_map_id
from storage.records import RobotRecord, User


async def absence_facts(services: Services, owner: User, record: RobotRecord) -> AbsenceFacts:
    """Return what would stop a robot of a user from connecting now."""
    machines = await services.cloud.machines.views()
    refused = await RobotFacts(services).last_refusal(record.user, record.id)
    return AbsenceFacts(
        robot=record.id,
        agv=_agv(record),
        refusal="" if refused is None else refused.reason,
        refused_ago=0.0 if refused is None else refused.ago,
        map_problem=await _map_problem(services, owner, record),
        quota_problem=await _quota_problem(services, record),
        cores=record.cores,
        free=tuple(machine.capacity - machine.given for machine in machines if machine.state == "ready"),
    )


def _agv(record: RobotRecord) -> str:
    """Return the AGV that a robot is by its file, as the bridge of AGVs writes it."""
    named = record.properties.get("vda5050")
    return f"{named.get('manufacturer', '?')}/{named.get('serialNumber', '?')}" if isinstance(named, dict) else ""


async def _map_problem(services: Services, owner: User, record: RobotRecord) -> str:
    if new_map_id(record.map) is not None:
        return ""
    try:
        await readable_head(services, owner, record.map)
    except PPaaSError as error:
        return str(error)
    return ""


async def _quota_problem(services: Services, record: RobotRecord) -> str:
    try:
        await services.cloud.users.check_container(record.user, record.cores)
    except QuotaExceeded as error:
        return str(error)
    return ""
