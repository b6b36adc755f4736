"""The demo of a building: simulated robots are sent between its floors, and take lifts that the cloud leads."""

import asyncio
import contextlib
from dataclasses import dataclass
from functools import partial
from statistics import fmean
from typing import Any

from rich.markup import escape
from rich.table import Table

from ppaas.buildings.building import json_of
from ppaas.clock import monotonic
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import save_map
from ppaas.messages.actionlib_msgs import Status
from ppaas.zones.reading import geojson_of
from robots.client.cloud_url import path_of
from robots.client.move_base import GoalOutcome, MoveBaseClient
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from robots.demo.building_stage import BUILDING, BuildingStage, set_stage
from robots.demo.demonstration import run_missions, show
from robots.demo.exploration import background
from robots.demo.mission import Mission
from robots.demo.options import CORES, CloudAccess, DemoOptions, no_lines
from robots.demo.report import BuildingReport
from robots.demo.scorer import Scorer
from robots.sim.floors.building import SimulatedBuilding
from robots.sim.floors.device_server import DeviceServer
from robots.sim.floors.ride_log import LoggedRide, RideLog
from robots.sim.simulator import Simulator

PERIOD = 0.5
"""Time between two questions for the state of a goal [s]."""


@dataclass(slots=True, kw_only=True)
class FloorMission(Mission):
    """Mission of a robot that is sent to floors over REST.

    Parameters
    ----------
    building : SimulatedBuilding
        Building that contains the robot.
    rest : RestClient
    floors : tuple of str
        Floor of each goal, and at last of the start.
    """

    building: SimulatedBuilding
    rest: RestClient
    floors: tuple[str, ...]

    @property
    def floor(self) -> str:
        """Floor on which the robot is."""
        return self.building.floor_of(self.building.robots[self.index])

    async def go(self, move_base: MoveBaseClient, number: int, goal: Pose2D, timeout: float) -> GoalOutcome:
        """Send the robot to a floor, and wait until it is there."""
        floor = self.floors[(number - 1) % len(self.floors)]
        began = monotonic()
        goals = path_of("robots", self.robot, "goals")
        view = await self.rest.post(goals, {"pose": list(goal), "floor": floor})
        self.write(f"{self.robot} is sent from {self.floor} to {floor}")
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout):
                while view["state"] in ("pending", "active"):
                    await asyncio.sleep(PERIOD)
                    view = self._noted(view, await self.rest.get(path_of("robots", self.robot, "goals", view["id"])))
        reached = view["state"] == "succeeded" and self.floor == floor
        status = Status.SUCCEEDED if reached else Status.ABORTED
        return GoalOutcome(status, view["text"] or view["state"], monotonic() - began, float("nan"))

    def _noted(self, before: dict[str, Any], view: dict[str, Any]) -> dict[str, Any]:
        """Show what the robot waits for, whenever that has changed."""
        self.progress.state = view["text"] or "driving"
        if view["text"] and view["text"] != before["text"]:
            self.write(f"{self.robot} on {self.floor}: {view['text']}")
        return view


def progress_table(missions: list[FloorMission]) -> Table:
    """Return a table with a row per robot: where it is, its goal, and for what it waits."""
    table = Table(title="PPaaS demo", title_justify="left")
    for heading in ("robot", "floor", "goal", "travelled (m)", "contacts", "state"):
        table.add_column(heading)
    for mission in missions:
        scorer, progress = Scorer(mission.building), mission.progress
        to = mission.floors[(progress.goal - 1) % len(mission.floors)] if progress.goal else "-"
        table.add_row(
            mission.robot,
            mission.floor,
            f"{progress.goal} on {to}",
            f"{scorer.distance(mission.index):.1f}",
            str(scorer.collisions(mission.index)),
            escape(progress.state),
        )
    return table


async def send_between_floors(options: DemoOptions, cloud: CloudAccess) -> BuildingReport:
    """Run the demo in a cloud; return its report.

    Raises
    ------
    PPaaSError
        The options are invalid, or the cloud rejects the login.
    """
    stage = await asyncio.to_thread(set_stage, options)
    rest = RestClient(cloud.url)
    login = await rest.login(cloud.admin, cloud.password)
    rides = RideLog(stage.simulated)
    missions = _missions(stage, rest, options)
    async with contextlib.AsyncExitStack() as stack:
        devices = await stack.enter_async_context(DeviceServer(stage.simulated))
        await stack.enter_async_context(background(Simulator(stage.simulated, after_step=rides.after_step).run()))
        await _put_building(rest, stage, devices)
        await _put_robots(rest, stage, missions, options)
        if options.console is not None:
            await stack.enter_async_context(background(show(partial(progress_table, missions), options.console)))
        began = monotonic()
        await run_missions(missions, cloud.url, login.token, options.keep_going)
        seconds = monotonic() - began
    return _report(seconds, missions, rides.rides)


def _report(seconds: float, missions: list[FloorMission], rides: list[LoggedRide]) -> BuildingReport:
    waited = [ride.waited for ride in rides] or [0.0]
    return BuildingReport(
        map=BUILDING,
        seconds=round(seconds, 2),
        robots=[mission.close() for mission in missions],
        rides=len(rides),
        lift_wait_mean_s=round(fmean(waited), 1),
        lift_wait_max_s=round(max(waited), 1),
        ride_mean_s=round(fmean([ride.rode for ride in rides] or [0.0]), 1),
    )


def _missions(stage: BuildingStage, rest: RestClient, options: DemoOptions) -> list[FloorMission]:
    write = options.write if options.console is None else no_lines
    return [
        FloorMission(
            stage.simulated, index, f"turtlebot-{index + 1}", each.course, write,
            building=stage.simulated, rest=rest, floors=each.floors,
        )
        for index, each in enumerate(stage.courses)
    ]  # fmt: skip


async def _put_building(rest: RestClient, stage: BuildingStage, devices: DeviceServer) -> None:
    """Publish the floors with their zones, and the record of the building with its devices."""
    building = stage.simulated.layout.building
    for floor in building.floors:
        yaml, image = save_map(stage.grids[floor.name], "map.pgm")
        await rest.upload_map(floor.map, yaml, image)
        await rest.put_zones(floor.map, geojson_of(stage.zones[floor.name]))
    await rest.put_building(BUILDING, json_of(devices.served(building)))


async def _put_robots(
    rest: RestClient, stage: BuildingStage, missions: list[FloorMission], options: DemoOptions
) -> None:
    for mission in missions:
        start = mission.course.start
        robot = RobotFile(
            map=stage.simulated.layout.building.floor(mission.floors[-1]).map,
            initial_pose=(start.x, start.y, start.theta),
            cores=CORES,
            base_global_planner=options.planner,
            base_local_planner=options.controller,
        )
        await rest.put_robot(mission.robot, robot)
