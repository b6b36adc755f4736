"""Command ``ppaas simulate ROBOT.json``: runs one simulated robot against a running cloud."""

import argparse
import logging
from pathlib import Path

from ppaas.log_lines import log_lines
from robots.cli import event_loop
from robots.cli.session import add_cloud_arguments, logged_in, token_of

logger = logging.getLogger(__name__)

NAME = "simulate"
HELP = "run one simulated robot against a running cloud"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("robot", type=Path, metavar="ROBOT.json", help="the robot file")
    parser.add_argument("--map", type=Path, required=True, metavar="FILE.yaml", help="map of the simulated world")
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
    parser.add_argument("--seed", type=int, default=0, help="seed of the sensor noise (%(default)s)")


def run(arguments: argparse.Namespace) -> int:
    """Drive until interrupted; return the exit status."""
    log_lines("%(levelname)s %(message)s", level=logging.INFO)
    event_loop.run(_run(arguments))
    return 0


async def _run(arguments: argparse.Namespace) -> None:
    # Imported here because ``ppaas --help`` loads this module, also where the simulator is not installed.
    import asyncio  # noqa: PLC0415

    from ppaas.zones.reading import zones_of  # noqa: PLC0415
    from ppaas.zones.zone import NO_ZONES  # noqa: PLC0415
    from robots.client.map_files import read_map_file  # noqa: PLC0415
    from robots.client.robot_client import RobotClient  # noqa: PLC0415
    from robots.client.robot_file import load_robot_file  # noqa: PLC0415
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
    robot_file = load_robot_file(arguments.robot)
    robot_id = arguments.id or arguments.robot.stem
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
