"""Check of a robot before its file or URDF is stored: whether its clone could be built."""

from msgspec.structs import replace
from starlette.concurrency import run_in_threadpool

from endpoints.services.services import Services
from engine.specs.clone_to_check import CloneToCheck
from engine.specs.robot_places import robot_config, robot_place
from ppaas.errors import InvalidParameter, InvalidRobot, RobotFault
from ppaas.maps.formats.map_yaml import parse_yaml
from ppaas.maps.new_map import new_map_id
from storage.ports import MapStore
from storage.records import RobotRecord
from storage.versions import YAML

BLANK_RESOLUTION = 0.05
"""Edge of the cells for a robot that makes its map [m]; its parameters set another."""


async def check_clone(services: Services, record: RobotRecord, urdf: bytes | None) -> None:
    """Refuse a robot that could not connect.

    Parameters
    ----------
    services : Services
        Without a checker of clones, only what the stores say is checked.
    record : RobotRecord
        The robot as it would be stored.
    urdf : bytes, optional
        Its URDF.

    Raises
    ------
    InvalidRobot
        The place of the robot or its clone refuses parts of the file; all that were found are listed.
    NotFound, NotPermitted, InvalidMap
        As of ``robot_place``.
    Unavailable
        The check is not possible now.
    """
    said = []
    try:
        config = (await run_in_threadpool(robot_place, services.map_store, record, urdf)).config
    except InvalidParameter as error:
        said, config = [RobotFault("parameters", str(error))], robot_config(record, urdf)
    found = []
    if services.clones is not None:
        resolution = await run_in_threadpool(_resolution, services.map_store, record.map)
        found = await services.clones.faults(CloneToCheck(replace(config, urdf_text=b""), resolution))
    found_texts = {fault.text for fault in found}
    faults = [*(fault for fault in said if fault.text not in found_texts), *found]
    if faults:
        raise InvalidRobot(faults)


def _resolution(maps: MapStore, name: str) -> float:
    if new_map_id(name) is not None:
        return BLANK_RESOLUTION
    with maps.open_map(name, only=(YAML,)) as opened:
        return parse_yaml(opened.paths[YAML].read_bytes()).resolution
