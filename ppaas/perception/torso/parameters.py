"""Parameters of the torso detector."""

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, check_numbers


class TorsoDetectorParameters(Parameters, frozen=True):
    """Parameters of the node ``torso_detector``.

    Parameters
    ----------
    range_min, range_max : float
        Limits of the distance from the camera at which people are detected [m].
    threshold : float
        Least score of a detection that is published, from 0 to 1.
    initialization_threshold : float
        Least score of a detection that may begin a track, from 0 to 1.
    max_rate : float
        Largest number of images per second that are used [Hz].
    """

    range_min: float = 0.7
    range_max: float = 6.0
    threshold: float = 0.5
    initialization_threshold: float = 0.6
    max_rate: float = 10.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=("range_max", "max_rate"))
        if not self.range_min < self.range_max <= FARTHEST:
            raise InvalidParameter(
                f"range_min must be below range_max, and that up to {FARTHEST:g} m, not {self.range_min} and "
                f"{self.range_max}"
            )
        if not self.threshold <= self.initialization_threshold <= 1.0:
            raise InvalidParameter(
                "threshold must be from 0 to initialization_threshold, and that up to 1, not "
                f"{self.threshold} and {self.initialization_threshold}"
            )


FARTHEST = 20.0
"""Limit of ``range_max`` [m]."""
