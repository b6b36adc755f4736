"""Service ``find_floor`` of localization: the floor of a robot that leaves a lift, by its scans and its barometer.

Nothing runs until it is called, and it ends with the answer.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ppaas.buildings.riding.air import check_pressure
from ppaas.errors import Conflict, PPaaSError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.messages.fleet.floors import FindFloor, FindFloorRequest, FindFloorResponse
from ppaas.messages.sensor_msgs import FluidPressure
from ppaas.nodes.base import Context, Reply, Service, Timer

if TYPE_CHECKING:
    from ppaas.buildings.riding.floor_search import FloorSearch

FIND_FLOOR = Service("find_floor", FindFloor)

PRESSURE_AGE = 10.0
"""Age from which a pressure is not the one of the air now [s]."""

LONGEST = 120.0
"""Longest time for which the floor is looked for [s]."""

CHECK = 0.5
"""Time between two looks whether that is over [s]."""


class _Asked:
    """A call that is open: what was asked, where the robot was then, and what is known."""

    def __init__(self, request: FindFloorRequest, reply: Reply, ends: tuple[Pose2D, Pose2D], now: float) -> None:
        self.request, self.reply, self.since = request, reply, now
        self.pose, self.odom = ends
        self.search: FloorSearch | None = None
        self.is_busy = False


class FloorService:
    """Finds the floor of a robot while somebody asks for it.

    Parameters
    ----------
    context : Context
        Context of the node.
    parameters : AmclParameters
    """

    def __init__(self, context: Context, parameters: AmclParameters) -> None:
        self._context, self._parameters = context, parameters
        self._pressure: tuple[float, float] | None = None
        self._asked: _Asked | None = None
        self._timer: Timer | None = None

    @property
    def wants_scans(self) -> bool:
        """Whether the next scan is of use."""
        return self._asked is not None and not self._asked.is_busy

    def heard(self, message: FluidPressure) -> None:
        """Take a message of the barometer.

        Raises
        ------
        InvalidInput
            It is no pressure of the air in pascals.
        """
        check_pressure(message.fluid_pressure)
        self._pressure = message.fluid_pressure, self._context.elapsed()

    def call(self, request: FindFloorRequest, reply: Reply, ends: tuple[Pose2D, Pose2D] | None) -> None:
        """Answer a call, later unless it asks for the pressure alone.

        Parameters
        ----------
        request : FindFloorRequest
        reply : callable
        ends : pair of Pose2D, optional
            Pose of the robot on the map, and its odometry there; None if it is not localized.

        Raises
        ------
        Unavailable
            The robot is not localized.
        """
        if not request.floors:
            reply(FindFloorResponse(pressure=self._pressure_now()))
            return
        if ends is None:
            raise Unavailable("the robot is not localized yet")
        self._answer(Conflict("another search for the floor has begun"))
        self._asked = _Asked(request, reply, ends, self._context.elapsed())
        self._timer = self._context.every(CHECK, self._check_time)

    def scan(self, points: NDArray[np.float64], odom: Pose2D) -> None:
        """Compare a scan with the maps, in a job: (n, 2) ends of beams in the robot's frame, and its odometry."""
        asked = self._asked
        if asked is None:
            return
        asked.is_busy = True
        pressure, elapsed = self._pressure_now(), self._context.elapsed() - asked.since

        def look(_cancelled: object) -> bool:
            if asked.search is None:
                # Imported only here, so that robots that do not ride do not load it.
                from ppaas.buildings.riding.floor_search import FloorSearch  # noqa: PLC0415

                asked.search = FloorSearch(asked.request, asked.pose, asked.odom, self._parameters)
            if pressure:
                asked.search.pressure(pressure, elapsed)
            asked.search.scan(points, odom)
            return asked.search.is_known

        self._context.start(look, lambda known: self._looked(asked, known))

    def _looked(self, asked: _Asked, known: bool | PPaaSError) -> None:
        asked.is_busy = False
        if asked is not self._asked:
            return
        if isinstance(known, PPaaSError):
            self._answer(known)
        elif known and asked.search is not None:
            self._answer(asked.search.answer())

    def _check_time(self) -> None:
        asked = self._asked
        if asked is None or asked.is_busy:
            return
        within = min(asked.request.timeout, LONGEST)
        if self._context.elapsed() - asked.since < within:
            return
        if asked.search is None:
            self._answer(Unavailable(f"no scan could be used within {within:g} s"))
        else:
            self._answer(asked.search.answer())

    def _answer(self, answer: FindFloorResponse | PPaaSError) -> None:
        asked, self._asked = self._asked, None
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if asked is not None:
            asked.reply(answer)

    def _pressure_now(self) -> float:
        """Return the pressure of the air [Pa]; 0 if it is not known."""
        if self._pressure is None or self._context.elapsed() - self._pressure[1] > PRESSURE_AGE:
            return 0.0
        return self._pressure[0]
