"""Parameters of merging."""

from ppaas.errors import InvalidParameter
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.parameters import Parameters, check_numbers


class MergeParameters(Parameters, frozen=True):
    """Parameters of a merge, in metres and radians. One set of defaults serves all lasers.

    Search: parts of ``part_travel`` of the second mapping, one every ``part_step``, are searched in all of the first,
    on a grid of ``resolution`` with rotations of ``heading_step``, and with ``fine_resolution`` around the best and
    the second best place. Their points are thinned to one per ``thin``. A place needs a score of ``least_score``; its
    scans are checked as for a loop closure, see `ClosureParameters`.

    Acceptance: at least ``least_matches`` places agree, from first to last ``least_travel`` apart along the drive;
    at the poses that they lead to, ``least_support`` of the scans of the second mapping that were taken near a key
    frame of the first pass the check, and ``least_confirmed`` of the points that both lasers see are within
    ``tolerance``. A set that leads elsewhere is a rival, and the merge is refused, if its support is at least
    ``rival_share`` of that, and the part of its points that are not confirmed at most ``rival_factor`` times as large,
    plus ``rival_margin``.
    """

    part_travel: float = 9.0
    part_step: float = 6.0
    resolution: float = 0.3
    fine_resolution: float = 0.1
    heading_step: float = 0.04
    thin: float = 0.5
    least_score: float = 0.65
    least_matches: int = 3
    least_travel: float = 12.0
    least_support: float = 0.6
    least_confirmed: float = 0.945
    tolerance: float = 0.2
    rival_share: float = 0.5
    rival_factor: float = 2.0
    rival_margin: float = 0.01
    closures: ClosureParameters = ClosureParameters()

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=_POSITIVE)
        for name in ("least_score", "least_support", "least_confirmed", "rival_share"):
            if getattr(self, name) > 1.0:
                raise InvalidParameter(f"{name} must be at most 1, not {getattr(self, name)}")


_POSITIVE = (
    "part_travel", "part_step", "resolution", "fine_resolution", "heading_step", "thin", "least_matches", "tolerance",
)  # fmt: skip
