"""Social layer: costs around people, which extend in the direction in which they walk.

Values and names are the same as in the proxemic layer of social_navigation_layers.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.kernels.people import raise_around
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D


class PersonNearby(NamedTuple):
    """Position [m] and velocity [m/s] of a person, in the frame of the map."""

    x: float
    y: float
    vx: float = 0.0
    vy: float = 0.0


@dataclass(frozen=True, slots=True)
class Proxemics:
    """Costs around people: a Gaussian, which is wider in front of a person who walks.

    Parameters
    ----------
    amplitude : float
        Cost at the position of a person; below 253, the cost of a collision.
    covariance : float
        Variance of the Gaussian [m²].
    cutoff : float
        Costs below this are ignored.
    factor : float
        Growth of the covariance in front of a person, relative to itself and per speed [s/m].
    group_amplitude : float
        Cost between people who stand and talk with each other; below 253.

    Raises
    ------
    InvalidParameter
        A parameter is not finite or out of range; the text names it.
    """

    amplitude: float = 77.0
    covariance: float = 0.25
    cutoff: float = 10.0
    factor: float = 5.0
    group_amplitude: float = 200.0

    def __post_init__(self) -> None:
        for name in ("amplitude", "covariance", "cutoff", "factor", "group_amplitude"):
            value = getattr(self, name)
            if not (math.isfinite(value) and (value > 0.0 or (name == "factor" and value == 0.0))):
                raise InvalidParameter(f"{name} must be finite and above 0, not {value}")
        for name in ("amplitude", "group_amplitude"):
            value = getattr(self, name)
            if value >= INSCRIBED_INFLATED_OBSTACLE:
                raise InvalidParameter(
                    f"{name} must be below {INSCRIBED_INFLATED_OBSTACLE}, the cost of a collision, not {value}"
                )

    def between(self) -> "Proxemics":
        """Return the costs around points between people who talk."""
        return replace(self, amplitude=self.group_amplitude)

    def add(self, costmap: Costmap, people: Iterable[PersonNearby]) -> bool:
        """Raise the costs of a costmap around people, in place.

        Parameters
        ----------
        costmap : Costmap
            Costmap in the frame of the map; its data are modified.
        people : iterable of PersonNearby
            People, with finite positions and velocities.

        Returns
        -------
        bool
            Whether any cost was raised.
        """
        frame = costmap.info.origin.inverse()
        turn = Pose2D(0.0, 0.0, frame.theta)
        rows = [(*(frame @ Pose2D(x, y))[:2], *(turn @ Pose2D(vx, vy))[:2]) for x, y, vx, vy in people]
        if not rows:
            return False
        raised = raise_around(
            costmap.data, np.array(rows), costmap.info.resolution,
            self.amplitude, self.covariance, self.cutoff, self.factor,
        )  # fmt: skip
        return raised > 0
