"""A vehicle and the way in which it is driven: its messages, what the cloud asks, and what becomes of both."""

import logging
import math
from collections.abc import Iterable
from typing import Any

from ppaas.clock import epoch
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.health.diagnostic_msgs import DiagnosticLevel, DiagnosticStatus, KeyValue
from ppaas.polygons import Points
from ppaas.wire.vda5050.master.instructions import PathEnded
from robots.bridges.core.notices import Notices, without_numbers
from robots.bridges.mavlink.authority import Given, SendMessage, Taken
from robots.bridges.mavlink.cloud_end import CloudEnd
from robots.bridges.mavlink.dialect import mavlink
from robots.bridges.mavlink.mission import MissionDrive, MissionStep
from robots.bridges.mavlink.modes import command
from robots.bridges.mavlink.place import SILENT, VehiclePlace
from robots.bridges.mavlink.proximity import Proximity
from robots.bridges.mavlink.station import GroundStation
from robots.bridges.mavlink.vehicle import BAD, ArmedChanged, ModeChanged, Restarted, Text, Vehicle
from robots.bridges.mavlink.velocity import VelocityDrive

logger = logging.getLogger("ppaas.bridge")

RATES = {
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 10.0,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 10.0,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 10.0,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 2.0,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 1.0,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 1.0,
    mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: 2.0,
    mavlink.MAVLINK_MSG_ID_OBSTACLE_DISTANCE: 10.0,
    mavlink.MAVLINK_MSG_ID_DISTANCE_SENSOR: 10.0,
}
"""Messages that the bridge asks for, and their rates [Hz]."""

ASK_AGAIN = 5.0
"""Time after which messages that do not come are asked for again [s]."""

LOST_AFTER = 2.0
"""Time without a pose after which a vehicle that drives a mission is made to stand [s]."""

REPORT, CHARGE = 5.0, 2.0
"""Times between two diagnostics that say the same, and between two charges [s]."""

PROGRESS = 1.0
"""Time between two reports of progress [s]."""

DEVIATION = 0.5
"""Standard deviation of a pose whose vehicle gives none [m]."""

KEPT = 5
"""Number of warnings of the vehicle that are kept."""


class Rover:
    """Vehicle that is a robot.

    Parameters
    ----------
    vehicle : Vehicle
    drive : VelocityDrive or MissionDrive
    place : VehiclePlace
    station : GroundStation
    robot : str
        Id of the robot.
    scans : bool
        Whether its clone takes scans of a robot that localizes itself.

    Attributes
    ----------
    cloud : CloudEnd or None
        The cloud, while the robot is connected.
    """

    def __init__(
        self, vehicle: Vehicle, drive: VelocityDrive | MissionDrive, place: VehiclePlace, station: GroundStation, *,
        robot: str, scans: bool,
    ) -> None:  # fmt: skip
        self.vehicle, self.drive, self._place, self._station = vehicle, drive, place, station
        self.cloud: CloudEnd | None = None
        self._robot, self._scans, self._notices = robot, scans, Notices()
        self._proximity = Proximity()
        self._lost = "the vehicle has sent no position yet"
        self._lost_since = self._asked_at = self._told_at = self._charged_at = self._progress_at = -math.inf
        self._published: str | None = None
        self._trouble, self._warnings = "", list[str]()
        self._told: tuple[str, ...] = ()

    def join(self, cloud: CloudEnd | None) -> None:
        """Take it that the robot is connected to the cloud, or is not."""
        self.cloud, self._published, self._told = cloud, None, ()

    # -- from the vehicle ----------------------------------------------------------------------------------------------

    def take(self, message: Any, now: float) -> None:
        """Take a message of the vehicle that arrived at a time [s]."""
        kind = message.get_type()
        if kind in ("OBSTACLE_DISTANCE", "DISTANCE_SENSOR"):
            self._scan(message, now)
        if message.get_srcComponent() != self.vehicle.component or not self._station.is_addressed_by(message):
            return  # a camera with a clock of its own, or an answer to another station
        for event in self.vehicle.take(message, now):
            self._happened(event, now)
        if kind == "COMMAND_ACK":
            self._do(self.drive.given(self.drive.authority.take_ack(message, now)), now)
        elif kind.startswith("MISSION_") and isinstance(self.drive, MissionDrive):
            self._do(self.drive.take(message, now), now)

    def _scan(self, message: Any, now: float) -> None:
        if not self._scans:
            advice = f'set "amcl": {{"localize": false}} in the file of robot {self._robot}'
            self._notices.tell(f"distances of the vehicle are not sent to the cloud: {advice}")
            return
        scan = self._proximity.take(message, now, Time.of(epoch()))
        if scan is not None and self.cloud is not None and not self._lost:
            self.cloud.scan(scan)

    def _happened(self, event: Restarted | ModeChanged | ArmedChanged | Text, now: float) -> None:
        match event:
            case Restarted():
                logger.warning("vehicle %d has restarted", self.vehicle.system)
                self._place.restarted()
                self._asked_at = -math.inf
            case ModeChanged():
                names = self.vehicle.book.name_of(event.before), self.vehicle.book.name_of(event.after)
                logger.info("vehicle %d: %s, was %s", self.vehicle.system, names[1], names[0])
            case ArmedChanged():
                logger.info("vehicle %d is %s", self.vehicle.system, "armed" if event.armed else "disarmed")
            case Text():
                self._said(event)
        if isinstance(self.drive, MissionDrive):
            self._do(self.drive.happened(event, now), now)
        else:
            self._do(self.drive.given(self.drive.authority.happened(event, now)), now)

    def _said(self, said: Text) -> None:
        is_bad = said.severity <= BAD
        logger.log(logging.WARNING if is_bad else logging.INFO, "vehicle %d says: %s", self.vehicle.system, said.text)
        if is_bad:
            self.drive.authority.note_text(said.text)
            self._warnings = [*(text for text in self._warnings if text != said.text), said.text][-KEPT:]

    # -- from the cloud ------------------------------------------------------------------------------------------------

    def velocity(self, speed: float, turn: float, now: float) -> None:
        """Take a velocity of the clone."""
        if isinstance(self.drive, VelocityDrive):
            self._do(self.drive.velocity(speed, turn, now), now)

    def follow(self, path: str, points: Points, now: float) -> None:
        """Take a path of the clone."""
        if isinstance(self.drive, MissionDrive):
            self._trouble = ""
            self._do(self.drive.follow(path, points, now), now)

    def cancel(self, path: str, now: float) -> None:
        """Take it that a path is cancelled."""
        if isinstance(self.drive, MissionDrive):
            self._do(self.drive.cancel(path, now), now)

    def stop(self, stopped: bool, now: float) -> None:
        """Take it that the robot is stopped in the cloud, or released; a path is cancelled by the clone itself."""
        if isinstance(self.drive, VelocityDrive):
            self._do(self.drive.stop(stopped, now), now)
        elif stopped:
            self._do(self.drive.given(self.drive.authority.release(now)), now)

    def set_pose(self, pose: Pose2D) -> None:
        """Take the pose of a vehicle whose local frame may be anywhere on the map."""
        if not self._place.set_pose(pose, self.vehicle):
            logger.warning("the pose of vehicle %d cannot be set: it knows its own", self.vehicle.system)

    def leave(self, reason: str, now: float) -> None:
        """Have the vehicle stand, because nobody leads it any more."""
        if isinstance(self.drive, MissionDrive):
            self._do(self.drive.fail(reason, now), now)
        else:
            self._do(self.drive.given(self.drive.authority.release(now)), now)

    # -- both ways -----------------------------------------------------------------------------------------------------

    def tick(self, now: float) -> None:
        """Do what is due, ten times a second."""
        self._look(now)
        motion = self._place.motion(self.vehicle)
        if isinstance(self.drive, MissionDrive):
            self._do(self.drive.tick(None if self._lost else motion, now), now)
        else:
            self._do(self.drive.tick(now, self._station.boot_ms()), now)
        if self.cloud is None:
            return
        if motion is not None and not self._lost:
            deviation = self.vehicle.deviation if self._place.anchor is not None else math.nan
            self.cloud.motion(motion, DEVIATION if math.isnan(deviation) else deviation)
        self._report(now)

    def _look(self, now: float) -> None:
        """Notice whether the vehicle is localized, and heard; ask for messages that do not come."""
        lost = self._place.why_lost(self.vehicle, now)
        if lost and not self._lost:
            self._lost_since = now
            logger.warning("vehicle %d is not localized: %s", self.vehicle.system, lost)
        self._lost = lost
        if now - self.vehicle.heard_at > SILENT:
            self._do(self.drive.given(self.drive.authority.forget(lost)), now)
        elif lost and now - self._asked_at >= ASK_AGAIN:
            self._asked_at = now
            for number, rate in RATES.items():
                wanted = (float(number), 1e6 / rate)
                self._station.send(
                    command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, wanted, self.vehicle.system, self.vehicle.component)
                )
        if lost and isinstance(self.drive, MissionDrive) and now - self._lost_since > LOST_AFTER:
            self._do(self.drive.fail(lost, now), now)

    def _do(self, steps: Iterable[MissionStep], now: float) -> None:
        for step in steps:
            match step:
                case SendMessage():
                    self._station.send(step.message)
                case Taken():
                    self._trouble = ""
                    logger.info("vehicle %d is driven by the bridge", self.vehicle.system)
                case Given():
                    self._yield(step.reason)
                case PathEnded():
                    logger.info("path %s ended: %s", step.path, step.reason or "reached")
                    if self.cloud is not None:
                        self.cloud.ended(step)

    def _yield(self, reason: str) -> None:
        """Report why the bridge does not drive, and cancel the goals that would go on."""
        if without_numbers(reason) != without_numbers(self._trouble):
            logger.warning("vehicle %d is not driven: %s", self.vehicle.system, reason)
        self._trouble = reason
        if self.cloud is not None and isinstance(self.drive, VelocityDrive):
            self.cloud.cancel_goals()

    # -- reports -------------------------------------------------------------------------------------------------------

    def _report(self, now: float) -> None:
        assert self.cloud is not None
        if self._published is None or without_numbers(self._published) != without_numbers(self._lost):
            self._published = self._lost
            self.cloud.localization(self._lost)
        if self.vehicle.charge is not None and now - self._charged_at >= CHARGE:
            self._charged_at = now
            self.cloud.charge(self.vehicle.charge)
        if isinstance(self.drive, MissionDrive) and now - self._progress_at >= PROGRESS:
            self._progress_at = now
            progress = self.drive.progress()
            if progress is not None:
                self.cloud.progress(progress)
        statuses = self.diagnostics()
        told = tuple(f"{one.level} {without_numbers(one.message)}" for one in statuses)
        if told != self._told or now - self._told_at >= REPORT:
            self._told, self._told_at = told, now
            self.cloud.diagnostics(statuses)

    def diagnostics(self) -> list[DiagnosticStatus]:
        """Return how the vehicle is, in words: its mode, what keeps it from driving, and what it warned of."""
        vehicle, name = self.vehicle, f"vehicle {self.vehicle.system}"
        level = DiagnosticLevel.ERROR if self._lost else DiagnosticLevel.WARN if self._trouble else DiagnosticLevel.OK
        facts = {
            "autopilot": vehicle.book.name,
            "mode": vehicle.mode_name,
            "armed": str(vehicle.armed).lower(),
            "bridge": self.drive.authority.hold.value,
            "fix": str(vehicle.fix),
            "messages without a valid signature": str(self._station.forged),
        }
        text = self._lost or self._trouble or f"{facts['mode']}, {'armed' if vehicle.armed else 'disarmed'}"
        first = DiagnosticStatus(int(level), name, text)
        first.values = [KeyValue(key, value) for key, value in facts.items()]
        warned = [DiagnosticStatus(int(DiagnosticLevel.WARN), f"{name}: text", text) for text in self._warnings]
        return [first, *warned]
