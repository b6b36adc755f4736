"""Parameters of loop closures, named as in slam_toolbox where one of theirs fits."""

from typing import NamedTuple

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, check_numbers


class DriftModel(NamedTuple):
    """Growth of the uncertainty with the distance travelled.

    Parameters
    ----------
    heading_walk, translation_walk : float
        Standard deviations per square root of a metre [rad/√m, m/√m].
    heading_bias, translation_bias : float
        Systematic errors per metre [rad/m, m/m].
    """

    heading_walk: float
    heading_bias: float
    translation_walk: float
    translation_bias: float


class ClosureParameters(Parameters, frozen=True):
    """Parameters of the search for loop closures, in metres and radians. One set of defaults serves all lasers.

    Of slam_toolbox: a submap is searched within ``loop_search_maximum_distance`` of its estimated place, on a grid of
    ``loop_search_space_resolution``, with points blurred by ``loop_search_space_smear_deviation``; a match needs a
    score of ``loop_match_minimum_response_coarse``, and as many as ``loop_match_minimum_chain_size`` of its scans
    have to pass the check.

    Drift, which shapes the windows: the variance of the heading grows by ``heading_walk``² per metre, its systematic
    part is ``heading_bias`` per metre; ``translation_walk`` and ``translation_bias`` are the same for the position.
    Windows reach ``window_deviations`` standard deviations to each side, and at least ``least_window`` and
    ``least_window_heading``.

    Others: a submap is ``submap_travel`` long; the latest ``fewest_submaps_between`` are not searched; a window above
    ``wide_window`` takes ``wide_submaps`` submaps to each side, and is refused as ambiguous if another place reaches
    ``ambiguous_share`` of the best score. Scans of a match are aligned with ``checked_scans`` of them: a scan passes if
    ``least_ratio`` of its points have a pair, ``least_confirmed`` of those visible are confirmed, and its position has
    an information of ``least_information`` [1/m²] in every direction, which it has not along a bare corridor.
    """

    loop_search_maximum_distance: float = 40.0
    loop_search_space_resolution: float = 0.1
    loop_search_space_smear_deviation: float = 0.1
    loop_search_maximum_heading: float = 0.8
    loop_match_minimum_response_coarse: float = 0.55
    loop_match_minimum_chain_size: int = 3
    heading_walk: float = 0.007
    heading_bias: float = 0.0008
    translation_walk: float = 0.015
    translation_bias: float = 0.003
    window_deviations: float = 2.5
    least_window: float = 0.3
    least_window_heading: float = 0.05
    heading_step: float = 0.015
    submap_travel: float = 3.0
    fewest_submaps_between: int = 2
    candidates: int = 8
    wide_window: float = 1.5
    wide_submaps: int = 3
    ambiguous_share: float = 0.92
    ambiguous_distance: float = 1.0
    checked_scans: int = 5
    least_ratio: float = 0.5
    least_confirmed: float = 0.8
    least_information: float = 10_000.0
    visibility_tolerance: float = 0.3

    @property
    def drift(self) -> DriftModel:
        """Growth of the uncertainty with the distance travelled."""
        return DriftModel(self.heading_walk, self.heading_bias, self.translation_walk, self.translation_bias)

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=_POSITIVE)
        shares = ("loop_match_minimum_response_coarse", "ambiguous_share", "least_ratio", "least_confirmed")
        for name in shares:
            if getattr(self, name) > 1.0:
                raise InvalidParameter(f"{name} must be at most 1, not {getattr(self, name)}")
        if self.loop_match_minimum_chain_size > self.checked_scans:
            raise InvalidParameter(
                f"loop_match_minimum_chain_size must be at most checked_scans, {self.checked_scans}, "
                f"not {self.loop_match_minimum_chain_size}"
            )


_POSITIVE = (
    "loop_search_maximum_distance", "loop_search_space_resolution", "loop_search_space_smear_deviation",
    "loop_search_maximum_heading", "loop_match_minimum_response_coarse", "loop_match_minimum_chain_size",
    "heading_step", "submap_travel", "candidates", "checked_scans", "ambiguous_share", "visibility_tolerance",
)  # fmt: skip
