"""Registration of AGVs as robots of the account, by their factsheets."""

import logging
import math
from typing import Any

from ppaas.errors import Conflict, NotFound
from ppaas.wire.vda5050.factsheets import Factsheet
from ppaas.wire.vda5050.topics import Address
from robots.bridges.agv.options import FleetOptions
from robots.client.rest import RestClient
from robots.client.rest_paths import path_of
from robots.client.robot_file import RobotFile

logger = logging.getLogger(__name__)

CORES = 0.25
"""Size of the container of an AGV [CPU cores]: it only plans."""


async def registered(
    rest: RestClient, robot: str, address: Address, *, map_id: str, sheet: Factsheet | None, options: FleetOptions
) -> dict[str, Any]:
    """Return the robot of an AGV as the cloud has it, which is registered now if it was not.

    Parameters
    ----------
    rest : RestClient
    robot : str
        Id of the robot.
    address : Address
        Address of the AGV.
    map_id : str
        Map of the AGV, as it names it.
    sheet : Factsheet or None
        Factsheet of the AGV.
    options : FleetOptions

    Raises
    ------
    NotFound
        The robot is not registered, and is not to be.
    Conflict
        The robot's file does not say that the robot follows paths itself.
    PPaaSError
        The cloud refuses the robot's file.
    """
    try:
        known: dict[str, Any] = await rest.get(path_of("robots", robot))
    except NotFound:
        if not options.register:
            raise
        file = robot_file(address, options.map_of(map_id), sheet, options.radius)
        await rest.put_robot(robot, file)
        logger.info("registered AGV %s as robot %s", address.agv, robot)
        known = await rest.get(path_of("robots", robot))
    if "follow_path" not in known.get("parameters", {}):
        raise Conflict(
            f'robot {robot!r} is driven by velocities: add "follow_path": {{}} to the parameters in its file'
        )
    return known


def robot_file(address: Address, map_id: str, sheet: Factsheet | None, radius: float | None) -> RobotFile:
    """Return the file of the robot that an AGV is; the radius [m] is that of the circle around its factsheet's size."""
    sizes: dict[str, Any] = {}
    if sheet is not None:
        body = sheet.physical_parameters
        radius = 0.5 * math.hypot(body.length, body.width)
    if radius is not None:
        sizes = {"global_costmap": {"robot_radius": radius}}
    return RobotFile(
        map=map_id,
        cores=CORES,
        parameters={"follow_path": {}, **sizes},
        description=f"AGV {address.agv}, by VDA 5050",
        properties={"vda5050": {"manufacturer": address.manufacturer, "serialNumber": address.serial}},
    )
