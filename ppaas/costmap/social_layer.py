"""The social layer: people are not to be come close to, least of all where they walk to.

Values and names are those of the proxemic layer of social_navigation_layers.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.kernels.people import raise_around
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D


class PersonNearby(NamedTuple):
    """Where somebody is, in the frame of the map [m], and how fast they walk [m/s]."""

    x: float
    y: float
    vx: float = 0.0
    vy: float = 0.0


@dataclass(frozen=True, slots=True)
class Proxemics:
    """How much room people are given.

    Parameters
    ----------
    amplitude : float
        Cost where a person stands; less than where a robot would collide.
    covariance : float
        Of the Gaussian around them [m²].
    cutoff : float
        What costs less than this costs nothing.
    factor : float
        By how much of itself, a metre a second, the covariance grows where they walk to.

    Raises
    ------
    InvalidParameter
        One is not finite or out of range; the text names it.
    """

    amplitude: float = 77.0
    covariance: float = 0.25
    cutoff: float = 10.0
    factor: float = 5.0

    def __post_init__(self) -> None:
        for name in ("amplitude", "covariance", "cutoff", "factor"):
            value = getattr(self, name)
            if not (math.isfinite(value) and (value > 0.0 or (name == "factor" and value == 0.0))):
                raise InvalidParameter(f"{name} must be finite and above 0, not {value}")
        if self.amplitude >= INSCRIBED_INFLATED_OBSTACLE:
            most = INSCRIBED_INFLATED_OBSTACLE - 1
            raise InvalidParameter(f"amplitude must be at most {most}, not {self.amplitude}: more is an obstacle")

    def add(self, costmap: Costmap, people: Iterable[PersonNearby]) -> bool:
        """Raise the costs of a costmap around people, in place.

        Parameters
        ----------
        costmap : Costmap
            Its own copy, in the frame of the map; written to.
        people : iterable of PersonNearby
            Finite.

        Returns
        -------
        bool
            Whether any cost is higher now.
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
