"""Parameters of a robot that follows people."""

import math
from typing import Annotated, Literal

import msgspec

from ppaas.parameters import Parameters, check_numbers

Side = Literal["behind", "left", "right"]

Distance = Annotated[float, msgspec.Meta(ge=0.6, le=10.0)]


class FollowParameters(Parameters, frozen=True):
    """Parameters of the node ``follow_person``.

    Parameters
    ----------
    distance : float
        Distance between the centres of robot and person [m].
    side : str
        Side of a walking person on which the robot drives: ``behind``, ``left`` or ``right``.
    frequency : float
        Rate at which the goal of Move Base moves [Hz].
    max_speed : float
        Fastest speed of following [m/s]; 0 for Move Base's.
    tolerance : float
        Change of the distance to a standing person for which the robot does not move [m].
    personal_space : float
        Distance that goals keep from other people [m].
    hidden_patience : float
        Time for which a hidden person is followed to the predicted position before the robot searches [s].
    search_timeout : float
        Time after which the robot gives a person up who was not found [s].
    resume_delay : float
        Time between the end of a client's goal and following again [s].
    cancel_pause : float
        Time for which the robot follows nobody after a client has cancelled its goal [s].
    field_of_view, view_range : float
        View of the robot's detector [rad, m], if the robot's people tracker does not report it.
    """

    distance: Distance = 1.2
    side: Side = "behind"
    frequency: Annotated[float, msgspec.Meta(ge=0.2, le=10.0)] = 2.0
    max_speed: float = 0.0
    tolerance: float = 0.4
    personal_space: float = 0.8
    hidden_patience: float = 2.0
    search_timeout: float = 30.0
    resume_delay: float = 1.0
    cancel_pause: float = 60.0
    field_of_view: float = math.radians(57.0)
    view_range: float = 5.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=("tolerance", "search_timeout", "field_of_view", "view_range"))
