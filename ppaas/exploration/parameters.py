"""Parameters of exploration, named as in explore_lite."""

from ppaas.parameters import Parameters, check_numbers


class ChoiceParameters(Parameters, frozen=True):
    """Parameters of the choice among frontiers.

    Parameters
    ----------
    min_frontier_size : float
        Smaller frontiers are ignored [m].
    potential_scale : float
        Weight of the length of the way.
    gain_scale : float
        Weight of the size of a frontier.
    largest_gain : float
        Size above which a frontier promises no more [m].
    hysteresis : float
        By how much another frontier must be better than the one that the robot drives to [m].
    """

    min_frontier_size: float = 0.5
    potential_scale: float = 1.0
    gain_scale: float = 0.5
    largest_gain: float = 4.0
    hysteresis: float = 2.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=("min_frontier_size", "potential_scale"))
