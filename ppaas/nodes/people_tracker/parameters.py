"""Parameters of the people tracker."""

import math

from ppaas.errors import InvalidParameter
from ppaas.messages.people_coordination import SensorView
from ppaas.parameters import Parameters, check_numbers

FASTEST = 20.0
"""Limit of the rate of reports [Hz]."""


class PeopleTrackerParameters(Parameters, frozen=True):
    """Parameters of the node ``people_tracker``.

    Parameters
    ----------
    publish_frequency : float
        Largest rate of reports and of the frames of people [Hz].
    tf_broadcast : bool
        Whether the frames of people are published.
    class_ids : tuple of str
        Classes in ``detections`` that are people.
    min_score : float
        Score from which a detection in ``people`` or ``detections`` may begin a track.
    sigma : float
        Standard deviation of positions that come without covariance [m].
    field_of_view, range_min, range_max : float
        Where a robot that sends ``people`` or ``detections`` sees people: ahead of its own frame [rad, m]. With a field
        of view of 0, somebody whom it no longer reports may still be there.
    """

    publish_frequency: float = 10.0
    tf_broadcast: bool = True
    class_ids: tuple[str, ...] = ("person",)
    min_score: float = 0.5
    sigma: float = 0.15
    field_of_view: float = 0.0
    range_min: float = 0.0
    range_max: float = 5.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=("publish_frequency", "sigma", "range_max"))
        if self.publish_frequency > FASTEST:
            raise InvalidParameter(f"publish_frequency must be at most {FASTEST:g} Hz, not {self.publish_frequency}")
        if self.min_score > 1.0:
            raise InvalidParameter(f"min_score must be from 0 to 1, not {self.min_score}")
        if self.field_of_view > 2.0 * math.pi + 1e-6:
            raise InvalidParameter(f"field_of_view must be at most 2π rad, not {self.field_of_view}")
        if self.range_min >= self.range_max:
            raise InvalidParameter(f"range_min must be below range_max, not {self.range_min} and {self.range_max}")

    def view(self) -> SensorView | None:
        """Return where the robot sees the people that it sends; None if it does not say."""
        if self.field_of_view <= 0.0:
            return None
        return SensorView(0.0, 0.0, 0.0, self.field_of_view, self.range_min, self.range_max)
