"""A bridge and a simulated rover on one clock; what they say passes as bytes of MAVLink 2."""

import math
from typing import Any

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.maps.georeference import GeoAnchor
from ppaas.wire.vda5050.master.instructions import PathEnded
from robots.bridges.mavlink.authority import VehicleAuthority
from robots.bridges.mavlink.dialect import Parser, mavlink
from robots.bridges.mavlink.mission import MissionDrive, PathProgress
from robots.bridges.mavlink.place import VehicleMotion, VehiclePlace
from robots.bridges.mavlink.rover import Rover
from robots.bridges.mavlink.station import addressed
from robots.bridges.mavlink.vehicle import BatteryReading, Vehicle
from robots.bridges.mavlink.velocity import VelocityDrive
from robots.sim.mavlink.body import RoverBody
from robots.sim.mavlink.rover import Make, SimulatedRover

ANCHOR = GeoAnchor(47.3977, 8.5456, math.radians(30.0))
STEP = 0.02
TICK = 5
"""Number of steps between two ticks of the bridge."""


class RecordedCloud:
    """Stands in for the cloud: keeps what the bridge publishes."""

    def __init__(self) -> None:
        self.motions: list[VehicleMotion] = []
        self.problems: list[str] = []
        self.ends: list[PathEnded] = []
        self.rests: list[float] = []
        self.scans: list[Any] = []
        self.charges: list[BatteryReading] = []
        self.words: list[str] = []
        self.cancelled = 0

    def motion(self, motion: VehicleMotion, deviation: float) -> None:
        self.motions.append(motion)
        assert deviation > 0.0

    def localization(self, problem: str) -> None:
        self.problems.append(problem)

    def ended(self, end: PathEnded) -> None:
        self.ends.append(end)

    def progress(self, progress: PathProgress) -> None:
        self.rests.append(progress.distance)

    def scan(self, scan: Any) -> None:
        self.scans.append(scan)

    def charge(self, charge: BatteryReading) -> None:
        self.charges.append(charge)

    def diagnostics(self, statuses: list[Any]) -> None:
        self.words = [status.message for status in statuses]

    def cancel_goals(self) -> None:
        self.cancelled += 1


class LoopStation:
    """Stands in for the station: what the bridge sends passes to the rover as bytes."""

    def __init__(self, rover: SimulatedRover) -> None:
        self._rover, self._writer, self._reader = rover, Parser(255), Parser(rover.system)
        self.sent: list[Any] = []
        self.forged = 0
        self.cut = False

    def send(self, message: Any) -> None:
        self.sent.append(message)
        if not self.cut:
            for read in self._reader.read(self._writer.write(message)):
                self._rover.take(read)

    def is_addressed_by(self, message: Any) -> bool:
        return addressed(message, 255)

    def boot_ms(self) -> int:
        return 0


class ClosedLoop:
    """A rover, and the bridge that drives it.

    Attributes
    ----------
    now : float
        Time [s].
    """

    def __init__(
        self, make: Make, *, waypoints: bool, arm: bool = True, anchor: GeoAnchor | None = ANCHOR, scans: bool = True,
    ) -> None:  # fmt: skip
        self.sim = SimulatedRover(make, RoverBody(ANCHOR.latitude, ANCHOR.longitude, math.radians(60.0)))
        autopilot = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA if make == "ardupilot" else mavlink.MAV_AUTOPILOT_PX4
        self.vehicle = Vehicle(1, 1, autopilot)
        authority = VehicleAuthority(self.vehicle, arm=arm)
        self.drive = MissionDrive(authority, ANCHOR) if waypoints else VelocityDrive(authority)
        self.station, self.cloud = LoopStation(self.sim), RecordedCloud()
        station: Any = self.station
        self.rover = Rover(self.vehicle, self.drive, VehiclePlace(anchor), station, robot="r", scans=scans)
        self.rover.join(self.cloud)  # type: ignore[arg-type]
        self.now = 100.0
        self.sim.now = self.sim._booted = self.now
        self.speed = self.turn = 0.0
        self.commands = True
        self._wire = Parser(1)
        self._wire.srcComponent = 1
        self._reader = Parser(255)
        self._steps = 0

    def run(self, seconds: float) -> None:
        """Let a time pass."""
        for _ in range(round(seconds / STEP)):
            self._step()

    def until(self, condition: Any, seconds: float = 60.0) -> None:
        """Let time pass until a condition holds; fail if it does not within a time [s]."""
        for _ in range(round(seconds / STEP)):
            if condition():
                return
            self._step()
        raise AssertionError(f"not within {seconds} s: {self.cloud.words}, {self.sim.mode}")

    def follow(self, path: str, *points: tuple[float, float]) -> None:
        """Give the bridge a path from where the robot is."""
        here = self.cloud.motions[-1].pose
        self.rover.follow(path, np.array([(here.x, here.y), *points]), self.now)

    @property
    def truth(self) -> Pose2D:
        """Where the rover really is, on the map."""
        x, y = ANCHOR.to_map(*self.sim.body.place())
        return Pose2D(x, y, math.remainder(math.pi / 2 - self.sim.body.heading - ANCHOR.yaw, math.tau))

    def _step(self) -> None:
        self.now += STEP
        self._steps += 1
        self.sim.step(STEP)
        for message in self.sim.take_sent():
            for read in self._reader.read(self._wire.write(message)):
                self.rover.take(read, self.now)
        if self._steps % TICK == 0:
            if self.commands and (self.speed or self.turn):
                self.rover.velocity(self.speed, self.turn, self.now)
            if self._steps % (10 * TICK) == 0:
                self.station.send(mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, 8, 0, 0, 4, 3))
            self.rover.tick(self.now)
