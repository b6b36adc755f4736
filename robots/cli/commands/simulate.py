"""Command ``ppaas simulate ROBOT.json``: runs simulated robots against a running cloud."""

import argparse
import logging
from contextlib import AsyncExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.log_lines import log_lines
from robots.cli import event_loop
from robots.cli.session import add_cloud_arguments, logged_in, token_of
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from ppaas.buildings.building import Building
    from robots.client.robot_file import RobotFile
    from robots.sim.floors.building import SimulatedBuilding

logger = logging.getLogger(__name__)

NAME = "simulate"
HELP = "run simulated robots against a running cloud"

DEVICE_PORT = 8590
"""Port at which the lifts and doors of a simulated building are served."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "robot", type=Path, nargs="+", metavar="ROBOT.json", help="the robot file; with --building, one or more"
    )
    world = parser.add_mutually_exclusive_group(required=True)
    world.add_argument("--map", type=Path, metavar="FILE.yaml", help="map of the simulated world")
    world.add_argument(
        "--building", metavar="ID", help="simulate all floors of this building of the cloud, with its lifts and doors"
    )
    parser.add_argument("--id", help="id of the robot (name of the robot file)")
    add_cloud_arguments(parser)
    parser.add_argument("--drift", type=float, default=1.0, help="factor on the errors of the odometry (%(default)s)")
    parser.add_argument(
        "--local-nodes",
        metavar="auto|NODE,...",
        help="run nodes of the clone on this computer: those that perform better here, or the ones named",
    )
    parser.add_argument(
        "--docks", type=Path, metavar="ZONES.geojson", help="put chargers and shelves at the docks of these zones, and "
        "a battery and a lift into the robot",
    )  # fmt: skip
    parser.add_argument("--charge", type=float, default=0.5, help="with --docks: charge at the start (%(default)s)")
    parser.add_argument(
        "--device-port", type=int, default=DEVICE_PORT, metavar="PORT",
        help="with --building: port of this computer at which lifts and doors are served (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--record", type=Path, metavar="FILE.json", help="with --building: write its record with the URLs of the "
        "simulated lifts and doors to a file, for 'ppaas building put'",
    )  # fmt: skip
    parser.add_argument("--seed", type=int, default=0, help="seed of the sensor noise (%(default)s)")


def run(arguments: argparse.Namespace) -> int:
    """Drive until interrupted; return the exit status."""
    if arguments.building is None and (len(arguments.robot) > 1 or arguments.record is not None):
        raise InvalidParameter("several robots and --record go with --building")
    if arguments.building is not None and (arguments.docks is not None or arguments.local_nodes is not None):
        raise InvalidParameter("leave out --docks and --local-nodes with --building")
    if arguments.id is not None and len(arguments.robot) > 1:
        raise InvalidParameter("--id names one robot: name the files of several as the robots")
    log_lines("%(levelname)s %(message)s", level=logging.INFO)
    event_loop.run(_run(arguments) if arguments.building is None else _run_building(arguments))
    return 0


async def _run(arguments: argparse.Namespace) -> None:
    # Imported here because ``ppaas --help`` loads this module, also where the simulator is not installed.
    import asyncio  # noqa: PLC0415

    from ppaas.zones.reading import zones_of  # noqa: PLC0415
    from ppaas.zones.zone import NO_ZONES  # noqa: PLC0415
    from robots.client.map_files import read_map_file  # noqa: PLC0415
    from robots.client.robot_client import RobotClient  # noqa: PLC0415
    from robots.onboard.computer import this_computer  # noqa: PLC0415
    from robots.onboard.local_nodes import parse_wanted_homes, run_local_nodes  # noqa: PLC0415
    from robots.onboard.task_group import run_together  # noqa: PLC0415
    from robots.sim.docks.fitting import fit_docks  # noqa: PLC0415
    from robots.sim.driver import Driver  # noqa: PLC0415
    from robots.sim.odometry import OdometryNoise  # noqa: PLC0415
    from robots.sim.robot import SimulatedRobotModel  # noqa: PLC0415
    from robots.sim.simulator import Simulator  # noqa: PLC0415
    from robots.sim.world import World  # noqa: PLC0415

    wanted = parse_wanted_homes(arguments.local_nodes) if arguments.local_nodes is not None else {}
    [(robot_id, robot_file)] = _robots(arguments).items()
    world = World(read_map_file(arguments.map), arguments.seed)
    zones = NO_ZONES if arguments.docks is None else zones_of(arguments.docks.read_bytes())
    docks = fit_docks(world, zones, robot_file.parameters)
    robot = world.add_robot(robot_file.pose, SimulatedRobotModel(odometry=OdometryNoise(drift=arguments.drift)))
    parts = docks.parts_of(robot, seed=arguments.seed, charge=arguments.charge)
    await logged_in(arguments).put_robot(robot_id, robot_file)
    async with RobotClient(arguments.url, robot=robot_id, token=token_of(arguments)) as client:
        logger.info("robot %s is connected to %s; stop it with Ctrl-C", robot_id, arguments.url)
        driver = Driver(robot, client, battery=parts.battery if zones.zones else None, lift=parts.lift)
        running = [Simulator(world, after_step=parts.after_step).run(), driver.run()]
        if wanted:
            running.append(run_local_nodes(client, await asyncio.to_thread(this_computer), wanted, logger.info))
        await run_together(*running)


def _robots(arguments: argparse.Namespace) -> "dict[str, RobotFile]":
    """Read the robot files; return them by the ids of the robots."""
    from robots.client.robot_file import load_robot_file  # noqa: PLC0415 - as above

    robots = {arguments.id or path.stem: load_robot_file(path) for path in arguments.robot}
    if len(robots) < len(arguments.robot):
        raise InvalidInput("two robot files have one name: the names are the ids of the robots")
    return robots


# -- buildings ---------------------------------------------------------------------------------------------------------


async def _run_building(arguments: argparse.Namespace) -> None:
    # Imported here for the same reason as above.
    from robots.client.robot_client import RobotClient  # noqa: PLC0415
    from robots.onboard.task_group import run_together  # noqa: PLC0415
    from robots.sim.driver import Driver  # noqa: PLC0415
    from robots.sim.floors.device_server import DeviceServer  # noqa: PLC0415
    from robots.sim.odometry import OdometryNoise  # noqa: PLC0415
    from robots.sim.robot import SimulatedRobotModel  # noqa: PLC0415
    from robots.sim.simulator import Simulator  # noqa: PLC0415

    rest, robots = logged_in(arguments), _robots(arguments)
    simulated = await _fetched(arguments)
    record = simulated.layout.building
    for robot_id, file in robots.items():
        floor = record.floor_of_map(file.map)
        if floor is None:
            maps = ", ".join(each.map for each in record.floors)
            raise InvalidInput(f"the map of robot {robot_id!r} is {file.map!r}, but the floors are {maps}")
        simulated.add_robot(file.pose, SimulatedRobotModel(odometry=OdometryNoise(drift=arguments.drift)), floor.name)
    async with AsyncExitStack() as stack:
        devices = await stack.enter_async_context(DeviceServer(simulated, port=arguments.device_port))
        _write_devices(arguments, devices.served(record))
        drivers = []
        for robot, (robot_id, file) in zip(simulated.robots, robots.items(), strict=True):
            await rest.put_robot(robot_id, file)
            client = RobotClient(arguments.url, robot=robot_id, token=token_of(arguments))
            drivers.append(Driver(robot, await stack.enter_async_context(client)))
        logger.info("%s connected to %s; stop with Ctrl-C", ", ".join(robots), arguments.url)
        await run_together(Simulator(simulated).run(), *(driver.run() for driver in drivers))


async def _fetched(arguments: argparse.Namespace) -> "SimulatedBuilding":
    """Fetch a building with the maps and zones of its floors; return its simulation."""
    import json  # noqa: PLC0415 - see above

    from ppaas.buildings.building import building_of  # noqa: PLC0415
    from ppaas.buildings.layout import layout_of  # noqa: PLC0415
    from ppaas.maps.formats.map_files import load_map  # noqa: PLC0415
    from ppaas.zones.reading import zones_of  # noqa: PLC0415
    from robots.cli.verbs.map_zones import geojson_of  # noqa: PLC0415
    from robots.sim.docks.fitting import fit_chargers  # noqa: PLC0415
    from robots.sim.floors.building import SimulatedBuilding  # noqa: PLC0415

    rest, grids, zones = logged_in(arguments), {}, {}
    found = await rest.get(path_of("buildings", arguments.building))
    record = building_of(json.dumps(found["building"]))
    for floor in record.floors:
        path = path_of("maps", floor.map)
        grids[floor.name] = load_map(await rest.fetch(f"{path}/yaml"), await rest.fetch(f"{path}/image"))
        zones[floor.name] = zones_of(await geojson_of(rest, f"{path}/zones"))
    layout = layout_of(record, zones)
    for warning in layout.warnings:
        logger.warning("%s", warning)
    simulated = SimulatedBuilding(layout, grids, arguments.seed)
    for name, world in simulated.floors.items():
        fit_chargers(world, zones[name])
    return simulated


def _write_devices(arguments: argparse.Namespace, record: "Building") -> None:
    """Print the URLs of the simulated devices, or write the record of the building with them."""
    from ppaas.buildings.building import json_of  # noqa: PLC0415 - see above
    from robots.cli.output_files import write_file  # noqa: PLC0415

    for lift in record.lifts:
        logger.info("lift %s: %s", lift.lift, lift.device)
    for door in record.doors:
        logger.info("door %s on %s: %s", door.door, door.floor, door.device or "stands open, for it has no device")
    if arguments.record is not None:
        write_file(arguments.record, json_of(record) + b"\n")
        logger.info("lead them with: ppaas building put %s %s", arguments.building, arguments.record)
