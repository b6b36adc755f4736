"""Parameters of exploration, named as in explore_lite."""

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, check_numbers

FASTEST = 10.0
"""Limit of ``planner_frequency`` [Hz]."""


class ChoiceParameters(Parameters, frozen=True):
    """Parameters of the choice among frontiers.

    Parameters
    ----------
    min_frontier_size : float
        Smaller frontiers are ignored [m].
    potential_scale : float
        Weight of the length of the path.
    gain_scale : float
        Weight of the size of a frontier.
    largest_gain : float
        Size above which a larger frontier is not preferred [m].
    hysteresis : float
        By how much another frontier must be better than the one that the robot drives to [m].
    others_penalty : float
        By how much a frontier must be better to which another robot is nearer [m].
    """

    min_frontier_size: float = 0.5
    potential_scale: float = 1.0
    gain_scale: float = 0.5
    largest_gain: float = 4.0
    hysteresis: float = 2.0
    others_penalty: float = 4.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=("min_frontier_size", "potential_scale"))


class ExploreParameters(ChoiceParameters, frozen=True):
    """Parameters of the node ``explore``.

    Parameters
    ----------
    planner_frequency : float
        Rate at which frontiers are looked for while the robot explores [Hz].
    progress_timeout : float
        Time without progress after which the robot gives a frontier up [s].
    patience : float
        Time for which the robot waits for a map, its pose, or free space, before the goal is aborted [s].
    """

    planner_frequency: float = 1.0
    progress_timeout: float = 30.0
    patience: float = 60.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        super().__post_init__()
        check_numbers(self, positive=("planner_frequency", "progress_timeout", "patience"))
        if self.planner_frequency > FASTEST:
            raise InvalidParameter(f"planner_frequency must be at most {FASTEST:g} Hz, not {self.planner_frequency}")
