"""Settings of the master control."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings for one AGV.

    Parameters
    ----------
    base_length : float
        Length of the route that is released ahead of the AGV [m]; the rest is the horizon.
    deviation, end_deviation : float
        Distance at which a node on the way, and the last one, count as reached [m].
    off_route : float
        Distance from its edge at which the AGV has left its route [m].
    start_distance : float
        Largest distance of the AGV from the start of its route [m].
    top_speed : float
        Fastest speed of the AGV [m/s], for the check of jumps.
    patience : float
        Time in which the AGV must take an order, or cancel one; then it is sent again, `TRIES` times in all [s].
    offline_patience : float
        Time for which the connection of an AGV may be broken while it has a path [s].
    max_nodes : int
        Largest number of nodes in a message.
    """

    base_length: float = 10.0
    deviation: float = 0.3
    end_deviation: float = 0.1
    off_route: float = 1.5
    start_distance: float = 1.0
    top_speed: float = 3.0
    patience: float = 10.0
    offline_patience: float = 30.0
    max_nodes: int = 100


TRIES = 3
"""Number of times that an order or a cancellation is sent."""
