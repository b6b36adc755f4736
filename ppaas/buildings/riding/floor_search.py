"""Search for the floor of a robot that leaves a lift, from the request to the answer.

What it is asked and what it answers are messages, so that it runs wherever the scans of the robot are.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.buildings.riding.floor_belief import FloorBelief
from ppaas.buildings.riding.floor_finder import FloorFinder
from ppaas.buildings.riding.floor_maps import SIGHT, grid_of
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.messages.fleet.floors import FindFloorRequest, FindFloorResponse
from ppaas.messages.geometry_msgs import Pose

LOOKS = 6
"""Number of scans from outside the car that the answer needs, all of which leave the same floor known."""


class FloorSearch:
    """Search for the floor of one robot.

    Parameters
    ----------
    request : FindFloorRequest
        With at least one floor.
    pose, odom : Pose2D
        Pose of the robot on the map that it is localized on, and its odometry there.
    parameters : AmclParameters

    Raises
    ------
    InvalidInput
        A map is damaged, a floor is missing, or a pressure is none of the air.
    """

    def __init__(self, request: FindFloorRequest, pose: Pose2D, odom: Pose2D, parameters: AmclParameters) -> None:
        levels = {part.floor: part.elevation for part in request.floors}
        self._belief = FloorBelief(levels, request.origin, request.destination)
        self._belief.lift_names(request.named)
        self._measured = request.pressure > 0.0
        if self._measured:
            self._belief.pressure(request.pressure, 0.0)
        self._since = request.seconds
        self._pressure = 0.0
        floors = {
            part.floor: (build_layers(grid_of(part), threads=1), part.change.planar() @ pose) for part in request.floors
        }
        self._finder = FloorFinder(self._belief, floors, odom, parameters)
        self._first, self._clear = odom, request.clear
        self._is_out = request.clear <= 0.0
        self._steady: tuple[str, int] = "", 0

    def pressure(self, pascal: float, elapsed: float) -> None:
        """Take the pressure of the air [Pa], at a time since the request [s].

        Raises
        ------
        InvalidInput
            It is no pressure of the air on Earth.
        """
        self._pressure = pascal
        if self._measured:
            self._belief.pressure(pascal, self._since + elapsed)

    def scan(self, points: NDArray[np.float64], odom: Pose2D) -> None:
        """Take a scan: (n, 2) ends of beams in the frame of the robot, and its odometry."""
        self._is_out = self._is_out or odom.distance_to(self._first) >= self._clear
        before = self._finder.looks
        self._finder.scan(points[np.hypot(points[:, 0], points[:, 1]) <= SIGHT], odom)
        found = self._finder.found
        floor = "" if found is None else found[0]
        if floor != self._steady[0]:
            self._steady = floor, 0
        if self._is_out and floor:
            self._steady = floor, self._steady[1] + self._finder.looks - before

    @property
    def is_known(self) -> bool:
        """Whether floor and pose are known, and more scans would not change that."""
        return self._steady[1] >= LOOKS

    def answer(self) -> FindFloorResponse:
        """Return what is known."""
        floor = self._belief.likeliest
        pose, fits = self._finder.on(floor)
        known = self._is_out and self._finder.found is not None
        share = self._belief.probabilities()[floor]
        return FindFloorResponse(floor, known, share, fits, Pose.of(pose), self._pressure)
