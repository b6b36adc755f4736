"""Parameters of the leg detector."""

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, check_numbers

FARTHEST = 30.0
"""Limit of ``max_range`` [m]."""


class LegDetectorParameters(Parameters, frozen=True):
    """Parameters of the node ``leg_detector``; the first three are named as in ROS's ``leg_detector``.

    Parameters
    ----------
    connection_threshold : float
        Distance between two successive hits, beyond the spacing of the beams, from which they are on two objects [m].
    min_points_per_group : int
        Least number of beams that hit a leg.
    leg_reliability_limit : float
        Score from which a detection may begin a track, from 0 to 1.
    min_reliability : float
        Score below which a detection is left out.
    min_range, max_range : float
        Limits of the distance at which people are detected [m].
    use_map : bool
        Whether hits on what is in the map are left out; needs localization.
    """

    connection_threshold: float = 0.1
    min_points_per_group: int = 1
    leg_reliability_limit: float = 0.7
    min_reliability: float = 0.1
    min_range: float = 0.2
    max_range: float = 5.0
    use_map: bool = True

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=("connection_threshold", "min_points_per_group", "max_range"))
        if not self.min_reliability <= self.leg_reliability_limit <= 1.0:
            raise InvalidParameter(
                "min_reliability and leg_reliability_limit must be from 0 to 1, the first not above the second, not "
                f"{self.min_reliability} and {self.leg_reliability_limit}"
            )
        if not self.min_range < self.max_range <= FARTHEST:
            raise InvalidParameter(
                f"min_range must be below max_range, and that at most {FARTHEST:g} m, not {self.min_range} and "
                f"{self.max_range}"
            )
