"""Settings of traffic: margins and times."""

from ppaas.parameters import Parameters, check_numbers


class TrafficParameters(Parameters, frozen=True):
    """Parameters of the traffic of a map.

    Parameters
    ----------
    margin : float
        Distance that a robot may be off its way [m]. Cells are as wide as the largest robot and two margins.
    wall_margin : float
        Distance from walls that robots keep in addition [m]: lasers see walls nearer than the map has them.
    patience : float
        Time after which a robot that does not get on counts as an obstacle [s].
    retry : float
        Time after which such a robot is tried again [s]; it doubles each time, up to eight times this.
    silence : float
        Time without a report after which a robot is granted nothing [s].
    forget : float
        Time without a report after which a robot is forgotten, and what it held is free [s].
    keep_blocked : float
        Time for which a cell that a robot found occupied is planned around [s].
    """

    margin: float = 0.1
    wall_margin: float = 0.1
    patience: float = 15.0
    retry: float = 10.0
    silence: float = 3.0
    forget: float = 600.0
    keep_blocked: float = 30.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=("margin", "patience", "retry", "silence", "forget", "keep_blocked"))
