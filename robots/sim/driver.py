"""Driver of a simulated robot: publishes its sensors and executes ``cmd_vel``."""

import asyncio
import logging
import math
from dataclasses import dataclass
from typing import Protocol

from ppaas.clock import Clock, monotonic
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.messages.base.std_msgs import Bool
from ppaas.messages.geometry_msgs import Twist
from ppaas.messages.sensor_msgs import BatteryState, CompressedImage
from ppaas.nodes.topics import (
    BATTERY_STATE,
    COMPRESSED_DEPTH_IMAGE,
    DEPTH_CAMERA_INFO,
    DEPTH_IMAGE,
    LIFT,
    LIFT_STATE,
    TF_STATIC,
)
from ppaas.perception.compressed_depth import compress
from robots.client.robot_client import RobotClient
from robots.onboard.task_group import run_together
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.robot import SimulatedRobot

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class SensorRates:
    """Publishing rates of the sensors [Hz].

    Raises
    ------
    InvalidParameter
        A rate is not a positive number.
    """

    odom: float = 20.0
    scan: float = 10.0
    depth: float = 5.0
    battery: float = 2.0

    def __post_init__(self) -> None:
        rates = self.odom, self.scan, self.depth, self.battery
        if not all(math.isfinite(rate) and rate > 0.0 for rate in rates):
            raise InvalidParameter(
                "odom, scan, depth and battery must be positive rates [Hz], not {:g}, {:g}, {:g} and {:g}".format(
                    *rates
                )
            )


LIFT_PERIOD = 0.5
"""Time between two reports of a lift [s]."""


class MeasuredBattery(Protocol):
    """Battery of a robot."""

    def message(self, stamp: float) -> BatteryState:
        """Return the measured state."""
        ...


class Lift(Protocol):
    """Lift of a robot."""

    @property
    def up(self) -> bool:
        """Whether it is up."""
        ...

    def command(self, up: bool) -> None:
        """Begin to move up or down."""
        ...


class FixedRate:
    """Fixed-rate schedule; missed times are skipped.

    Parameters
    ----------
    rate : float
        Rate [Hz].
    start : float
        First due time [s].
    """

    SLACK = 0.002
    """Tolerance for timers that fire early [s]."""

    def __init__(self, rate: float, start: float) -> None:
        self._rate = rate
        self._start = start
        self._count = 0

    @property
    def next(self) -> float:
        """Next due time [s]."""
        return self._start + self._count / self._rate

    def take(self, now: float) -> bool:
        """Return whether the schedule is due at ``now`` [s]; if so, advance it."""
        if now < self.next - self.SLACK:
            return False
        self._count = math.floor((now + self.SLACK - self._start) * self._rate) + 1
        return True


class Driver:
    """Runs one simulated robot.

    Parameters
    ----------
    robot : SimulatedRobot
        The robot.
    client : RobotClient
        Connected client in the role of the robot.
    rates : SensorRates, optional
        Rates of the sensors.
    clock : callable
        Monotonic seconds.
    compressed : bool
        Whether depth images are sent as ``compressedDepth``, in a fifth of the bytes.
    battery : MeasuredBattery, optional
        Battery of the robot, of which nothing is published without one.
    lift : Lift, optional
        Lift of the robot, likewise.
    """

    def __init__(
        self,
        robot: SimulatedRobot,
        client: RobotClient,
        rates: SensorRates | None = None,
        clock: Clock = monotonic,
        *,
        compressed: bool = True,
        battery: MeasuredBattery | None = None,
        lift: Lift | None = None,
    ) -> None:
        self._robot = robot
        self._battery, self._lift = battery, lift
        self._client = client
        self._rates = rates or SensorRates()
        self._clock = clock
        self._compressed = compressed
        self.commands = 0

    async def run(self) -> None:
        """Drive until cancelled.

        Raises
        ------
        PPaaSError
            The client has failed.
        """
        await self._client.subscribe("cmd_vel", Twist, self._command, queue_size=1)
        tasks = [self._measure()]
        if self._robot.model.camera is not None:
            tasks.append(self._photograph(self._robot.model.camera))
        if self._battery is not None:
            tasks.append(self._report(self._battery))
        if self._lift is not None:
            tasks.append(self._serve(self._lift))
        await run_together(*tasks)

    async def _measure(self) -> None:
        start = self._clock()
        odom, scan = FixedRate(self._rates.odom, start), FixedRate(self._rates.scan, start)
        while True:
            now = self._clock()
            # Odometry first: localization needs the pose when it processes the scan.
            if odom.take(now):
                await self._client.publish("odom", self._robot.odometry())
            if scan.take(now):
                await self._client.publish("scan", self._robot.scan(), newest_only=True)
            await asyncio.sleep(max(min(odom.next, scan.next) - self._clock(), 0.0))

    async def _report(self, battery: MeasuredBattery) -> None:
        due = FixedRate(self._rates.battery, self._clock())
        while True:
            if due.take(self._clock()):
                stamp = self._robot.odometry().header.stamp.seconds()
                await self._client.publish(BATTERY_STATE.name, battery.message(stamp), newest_only=True)
            await asyncio.sleep(max(due.next - self._clock(), 0.0))

    async def _serve(self, lift: Lift) -> None:
        await self._client.subscribe(LIFT.name, Bool, lambda wanted: lift.command(wanted.data))
        while True:
            await self._client.publish(LIFT_STATE.name, Bool(lift.up), newest_only=True)
            await asyncio.sleep(LIFT_PERIOD)

    async def _photograph(self, camera: DepthCameraModel) -> None:
        await self._client.publish(TF_STATIC.name, camera.transforms(self._robot.model.base_frame))
        due = FixedRate(self._rates.depth, self._clock())
        while True:
            if due.take(self._clock()):
                await self._publish_image()
            await asyncio.sleep(max(due.next - self._clock(), 0.0))

    async def _publish_image(self) -> None:
        info, depths = self._robot.camera_info(), self._robot.depths()
        await self._client.publish(DEPTH_CAMERA_INFO.name, info, newest_only=True)
        if not self._compressed:
            image = self._robot.camera.image(depths, info.header.stamp.seconds())
            await self._client.publish(DEPTH_IMAGE.name, image, newest_only=True)
            return
        # In a thread, since compression takes as long as the period of the odometry.
        form, data = await asyncio.to_thread(compress, depths)
        await self._client.publish(
            COMPRESSED_DEPTH_IMAGE.name, CompressedImage(info.header, form, data), newest_only=True
        )

    def _command(self, twist: Twist) -> None:
        try:
            self._robot.command(twist)
        except InvalidInput as error:
            logger.warning("rejected a command of the cloud: %s", error)
            return
        self.commands += 1
