"""One vehicle as a robot of the cloud, by velocities or by waypoints."""

import asyncio
import logging
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ppaas.clock import monotonic
from ppaas.errors import Conflict, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.listener_faults import ListenerFaults
from ppaas.maps.georeference import GeoAnchor, anchor_of
from robots.bridges.core.notices import Notices
from robots.bridges.mavlink.authority import VehicleAuthority
from robots.bridges.mavlink.cloud_end import CloudEnd, Requests
from robots.bridges.mavlink.mission import MissionDrive
from robots.bridges.mavlink.place import SILENT, VehiclePlace
from robots.bridges.mavlink.rover import Rover
from robots.bridges.mavlink.station import Station, StationOptions
from robots.bridges.mavlink.vehicle import Vehicle
from robots.bridges.mavlink.velocity import VelocityDrive
from robots.client.cloud_url import path_of
from robots.client.rest import RestClient

logger = logging.getLogger("ppaas.bridge")

TICK, HEARTBEAT = 0.1, 1.0
"""Times between two setpoints and poses, and between two heartbeats of this station [s]."""

LEAVE_AFTER = 10.0
"""Time without a heartbeat of the vehicle after which its robot leaves the cloud [s]."""

CLOUD_SILENT = 5.0
"""Time without the cloud after which a vehicle that drives a mission is made to stand [s]."""


@dataclass(frozen=True, slots=True)
class BridgeOptions:
    """Options of a bridge.

    Attributes
    ----------
    station : StationOptions
    anchor : GeoAnchor or None
        Where the robot's map is on the Earth; None for what the map says itself.
    arm : bool
        Whether the bridge may arm the vehicle.
    """

    station: StationOptions
    anchor: GeoAnchor | None = None
    arm: bool = False


class MavlinkBridge:
    """Joins a vehicle with its robot.

    Parameters
    ----------
    url, token, robot : str
        URL of the cloud, token of the account, id of the robot.
    options : BridgeOptions
    """

    def __init__(self, url: str, token: str, robot: str, options: BridgeOptions) -> None:
        self._url, self._token, self._robot, self._options = url, token, robot, options
        self._station = Station(options.station, self._received)
        self._rover: Rover | None = None
        self._heard = asyncio.Event()
        self._heartbeat_at = self._cloud_at = -math.inf
        self._faults, self._notices = ListenerFaults(logger), Notices()

    async def run(self) -> None:
        """Carry messages until cancelled.

        Raises
        ------
        PPaaSError
            The cloud refuses the robot; its map has no anchor, which a mission needs; the port is in use; or the
            vehicle is none that the bridge drives.
        """
        known, anchor = await self._look_up()
        line = asyncio.create_task(self._station.line.run())
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(_wait(line))
                heartbeat = await self._find()
                self._rover = self._joined(heartbeat, anchor, known["parameters"])
                group.create_task(self._tick(self._rover))
                group.create_task(self._connect(self._rover))
        except* PPaaSError as errors:
            raise errors.exceptions[0] from None
        finally:
            if self._rover is not None:
                self._rover.leave("the bridge ends", monotonic())  # while the line is still open
            line.cancel()
            await asyncio.gather(line, return_exceptions=True)

    async def _look_up(self) -> tuple[dict[str, Any], GeoAnchor | None]:
        """Return the robot as the cloud knows it, and the anchor of its map."""
        rest = RestClient(self._url, self._token)
        known: dict[str, Any] = await rest.get(path_of("robots", self._robot))
        anchor = self._options.anchor or anchor_of(await rest.fetch(path_of("maps", str(known["map"]), "yaml")))
        if anchor is None and "follow_path" in known["parameters"]:
            raise Conflict(
                f"robot {self._robot!r} follows paths, and map {known['map']!r} is not anchored on the Earth, where "
                "missions are: give --anchor LATITUDE,LONGITUDE,YAW"
            )
        return known, anchor

    async def _find(self) -> Any:
        logger.info("waiting for the heartbeat of a vehicle")
        while (heartbeat := self._station.finder.choose(monotonic())) is None:
            if self._options.station.address.kind != "udpin":
                self._station.heartbeat()  # some vehicles and routers are silent until a station speaks
            await asyncio.sleep(TICK if self._station.finder.found else HEARTBEAT)
        return heartbeat

    def _joined(self, heartbeat: Any, anchor: GeoAnchor | None, parameters: Mapping[str, Any]) -> Rover:
        follows_paths = "follow_path" in parameters
        vehicle = Vehicle(heartbeat.get_srcSystem(), heartbeat.get_srcComponent(), heartbeat.autopilot)
        authority = VehicleAuthority(vehicle, arm=self._options.arm)
        drive: VelocityDrive | MissionDrive = VelocityDrive(authority)
        if follows_paths and anchor is not None:
            drive = MissionDrive(authority, anchor)
        self._station.choose(vehicle.system)
        way = "by waypoints" if follows_paths else "by velocities"
        logger.info("vehicle %d, %s, is robot %s, driven %s", vehicle.system, vehicle.book.name, self._robot, way)
        scans = parameters.get("amcl", {}).get("localize") is False
        return Rover(vehicle, drive, VehiclePlace(anchor), self._station, robot=self._robot, scans=scans)

    def _received(self, message: Any, now: float) -> None:
        if self._rover is not None:
            self._faults.deliver("the part of the bridge that takes messages", self._rover.take, message, now)
            self._heard.set()

    async def _tick(self, rover: Rover) -> None:
        while True:
            now = monotonic()
            if now - self._heartbeat_at >= HEARTBEAT:
                self._heartbeat_at = now
                self._station.heartbeat()
            self._faults.call("the bridge", rover.tick, now)
            self._watch_cloud(rover, now)
            await asyncio.sleep(max(TICK - (monotonic() - now), 0.0))

    def _watch_cloud(self, rover: Rover, now: float) -> None:
        if rover.cloud is None or rover.cloud.link.connected:
            self._cloud_at = now
        elif now - self._cloud_at > CLOUD_SILENT:
            rover.leave("the connection to the cloud was lost", now)

    # -- the cloud -----------------------------------------------------------------------------------------------------

    async def _connect(self, rover: Rover) -> None:
        """Be the robot in the cloud whenever the vehicle is heard."""
        while True:
            self._heard.clear()
            await self._heard.wait()
            if monotonic() - rover.vehicle.heard_at > SILENT:
                continue
            cloud = CloudEnd(self._url, self._token, self._robot, self._requests(rover))
            async with cloud.link:
                await cloud.subscribe(follows_paths=isinstance(rover.drive, MissionDrive))
                rover.join(cloud)
                logger.info("robot %s is connected to the cloud", self._robot)
                try:
                    await self._stay(rover, cloud)
                finally:
                    rover.join(None)

    async def _stay(self, rover: Rover, cloud: CloudEnd) -> None:
        closed = asyncio.create_task(cloud.link.closed())
        try:
            while monotonic() - rover.vehicle.heard_at <= LEAVE_AFTER:
                await asyncio.wait({closed}, timeout=HEARTBEAT)
                if closed.done():
                    closed.result()
        finally:
            closed.cancel()
        await cloud.say_farewell()
        logger.info("vehicle %d is not heard: robot %s leaves the cloud", rover.vehicle.system, self._robot)

    def _requests(self, rover: Rover) -> Requests:
        drive = rover.drive

        def goals(active: frozenset[str]) -> None:
            if isinstance(drive, VelocityDrive):
                drive.goals(active)

        def initial_pose(pose: Pose2D) -> None:
            rover.set_pose(pose)

        return Requests(
            velocity=lambda speed, turn: rover.velocity(speed, turn, monotonic()),
            goals=goals,
            follow=lambda path, points: rover.follow(path, points, monotonic()),
            cancel=lambda path: rover.cancel(path, monotonic()),
            initial_pose=initial_pose,
            stop=lambda stopped: rover.stop(stopped, monotonic()),
        )


async def _wait(line: "asyncio.Task[None]") -> None:
    """Wait for a line, which goes on when this is cancelled."""
    await asyncio.shield(line)
