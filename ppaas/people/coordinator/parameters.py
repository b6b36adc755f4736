"""Parameters of the coordinator."""

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, check_numbers


class CoordinatorParameters(Parameters, frozen=True):
    """Parameters of a coordinator.

    Parameters
    ----------
    gate : float
        Squared Mahalanobis distance within which a torso can be a known person.
    farthest : float
        Distance between a torso and a person in view beyond which they are different, apart from the deviations of the
        robots [m].
    new_person : float
        Cost of taking a torso for a new person instead of one who was hidden: the squared Mahalanobis distance, plus
        twice the logarithm of how many times wider than 0.3 m the prediction is.
    seen_for : float
        Time without a detection for which a person still counts as seen while some robot should see them [s].
    predict_for : float
        Time for which a hidden person is predicted before being lost [s].
    forget_after : float
        Time after which a person who is lost gets a new identity [s].
    deviation_history : float
        Time over which the maximum deviation of a robot is taken [s].
    report_timeout : float
        Age of a report from which a robot sees nobody [s].
    robot_timeout : float
        Time without reports after which a robot has left the group [s].
    switch_history : float
        Time over which the cost of another robot must decrease before it takes over [s].
    switch_samples : int
        Number of costs in that time.
    hold : float
        Time for which a robot that handed a person over does not get the same person back [s].
    lost_sight : float
        Time after which a robot that does not see the person hands over to a nearer one that does [s].
    without_sight : float
        Time after which it hands over to a robot that is farther away, too [s].
    give_up_for : float
        Time for which a robot that gave a person up does not get the same person again [s].
    cells_per_cycle : int
        Cells of cost fields that a cycle may grow.
    body_radius : float
        Radius of a person who hides another [m].
    """

    gate: float = 13.8
    farthest: float = 0.7
    new_person: float = 10.0
    seen_for: float = 0.8
    predict_for: float = 5.0
    forget_after: float = 60.0
    deviation_history: float = 10.0
    report_timeout: float = 1.0
    robot_timeout: float = 30.0
    switch_history: float = 2.0
    switch_samples: int = 5
    hold: float = 6.0
    lost_sight: float = 1.0
    without_sight: float = 6.0
    give_up_for: float = 10.0
    cells_per_cycle: int = 100_000
    body_radius: float = 0.25

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=self.__struct_fields__)
        if self.switch_samples < 2:
            raise InvalidParameter(f"switch_samples must be at least 2, not {self.switch_samples}")
