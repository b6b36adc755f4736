"""Driver of a simulated robot: publishes its sensors and executes ``cmd_vel``."""

import asyncio
import logging
import math
from dataclasses import dataclass

from ppaas.clock import Clock, monotonic
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.messages.geometry_msgs import Twist
from robots.client.robot_client import RobotClient
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

    def __post_init__(self) -> None:
        if not all(math.isfinite(rate) and rate > 0.0 for rate in (self.odom, self.scan)):
            raise InvalidParameter(f"odom and scan must be positive rates [Hz], not {self.odom} and {self.scan}")


class Schedule:
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
    """

    def __init__(
        self, robot: SimulatedRobot, client: RobotClient, rates: SensorRates | None = None, clock: Clock = monotonic
    ) -> None:
        self._robot = robot
        self._client = client
        self._rates = rates or SensorRates()
        self._clock = clock
        self.commands = 0

    async def run(self) -> None:
        """Drive until cancelled.

        Raises
        ------
        PPaaSError
            The client has failed.
        """
        await self._client.subscribe("cmd_vel", Twist, self._command, queue_size=1)
        start = self._clock()
        odom, scan = Schedule(self._rates.odom, start), Schedule(self._rates.scan, start)
        while True:
            now = self._clock()
            # Odometry first: localization needs the pose when it processes the scan.
            if odom.take(now):
                await self._client.publish("odom", self._robot.odometry())
            if scan.take(now):
                await self._client.publish("scan", self._robot.scan(), newest_only=True)
            await asyncio.sleep(max(min(odom.next, scan.next) - self._clock(), 0.0))

    def _command(self, twist: Twist) -> None:
        try:
            self._robot.command(twist)
        except InvalidInput as error:
            logger.warning("rejected a command of the cloud: %s", error)
            return
        self.commands += 1
