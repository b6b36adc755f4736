"""Parameters of docking, named as in Nav2's docking server where it has them."""

from typing import Annotated, Any, Literal

from msgspec import Meta, field

from ppaas.docking.approach import BodyOutline, DockControl
from ppaas.docking.dock import DockStance
from ppaas.footprints import Footprint, check_corners
from ppaas.parameters import Parameters, check_numbers

MOST_RETRIES = 1000


class DockType(Parameters, frozen=True):
    """Settings for all docks of a type.

    Parameters
    ----------
    detection : str
        Detector by its name, see `ppaas.docking.detection`.
    detector : dict
        Its parameters.
    dock_direction : str
        Whether the robot drives into the dock forward or backward.
    distance : float, optional
        Distance from the origin of a docked robot to what the detector finds [m], negative if the robot stands past it;
        by default the extent of the robot.
    staging_distance : float
        Distance from the docked pose at which the robot begins to look for the dock [m].
    docking_threshold : float
        Distance from the docked pose at which the robot stands at the dock [m].
    lateral_tolerance : float
        Distance beside the axis of the dock at which there is no contact any more [m].
    overshoot : float
        Distance by which the robot presses on if there is no charge [m].
    blind_distance : float
        Distance from the docked pose from which the dock need not be seen any more [m].
    charges : bool
        Whether docks that goals give by their poses charge the robot.
    charging_threshold : float
        Current from which the battery counts as charged [A].
    load : Footprint
        Outline of what the robot lifts and carries away, in the frame of the robot that has docked [m]; empty if it
        carries nothing away. Such docks do not charge.
    """

    detection: str = "scan_line"
    detector: dict[str, Any] = field(default_factory=dict)
    dock_direction: Literal["forward", "backward"] = "forward"
    distance: float | None = None
    staging_distance: float = 0.7
    docking_threshold: float = 0.015
    lateral_tolerance: float = 0.04
    overshoot: float = 0.02
    blind_distance: float = 0.1
    charges: bool = True
    charging_threshold: float = 0.5
    load: Footprint = ()

    def __post_init__(self) -> None:
        """Check the ranges."""
        if self.load:
            check_corners(self.load)
        positive = ("staging_distance", "docking_threshold", "lateral_tolerance", "charging_threshold")
        check_numbers(self, positive=positive, signed=("distance",))

    def stance(self, body: BodyOutline) -> DockStance:
        """Return how a robot stands at such a dock."""
        backward = self.dock_direction == "backward"
        extent = body.back if backward else body.front
        return DockStance(extent if self.distance is None else self.distance, backward)


class DockingParameters(Parameters, frozen=True):
    """Parameters of the node ``docking_server``.

    Parameters
    ----------
    controller_frequency : float
        Rate of the control cycle [Hz].
    initial_perception_timeout : float
        Time within which the dock must be seen from the staging pose [s].
    wait_charge_timeout : float
        Time within which the battery must be charged [s].
    dock_approach_timeout : float
        Time for the way from the staging pose to the dock [s].
    max_retries : int
        Number of further approaches to a dock.
    dock_prestaging_tolerance : float
        Distance from the staging pose at which the robot need not drive there first [m].
    retry_offset : float
        Step by which further approaches are beside the axis of the dock [m]: to the left, to the right, twice so far.
    patience : float
        Time for which the robot waits for what is in its way [s].
    lift_timeout : float
        Time within which the lift must be up, or down [s].
    not_charging_timeout : float
        Time after which a docked robot whose battery is not charged is reported [s].
    controller : DockControl
    dock_types : dict of str to DockType
        By their names.
    next_docks : dict of str to str
        Dock to try if a dock fails, by the names of docks.
    """

    controller_frequency: Annotated[float, Meta(gt=0.0, le=100.0)] = 20.0
    initial_perception_timeout: float = 5.0
    wait_charge_timeout: float = 5.0
    dock_approach_timeout: float = 30.0
    max_retries: Annotated[int, Meta(ge=0, le=MOST_RETRIES)] = 3
    dock_prestaging_tolerance: float = 0.15
    retry_offset: float = 0.01
    patience: float = 15.0
    lift_timeout: float = 15.0
    not_charging_timeout: float = 30.0
    controller: DockControl = DockControl()
    dock_types: dict[str, DockType] = field(default_factory=dict)
    next_docks: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the ranges."""
        positive = (
            "initial_perception_timeout", "wait_charge_timeout", "dock_approach_timeout", "not_charging_timeout",
            "lift_timeout",
        )  # fmt: skip
        check_numbers(self, positive=positive)
