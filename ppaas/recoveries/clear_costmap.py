"""Forgets obstacles that were seen a while ago and may not be there any more (``clear_costmap_recovery.cpp``)."""

from typing import Any, ClassVar

from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, read_parameters
from ppaas.recoveries.base import AffectedMaps, NotNegative, Recovery, RecoveryRequest

LAYERS = ("obstacles", "obstacle_layer")
"""What ROS calls the one layer that can be cleared: what was seen. The map itself stays."""


class ClearCostmapParameters(Parameters, frozen=True):
    """Parameters of ``clear_costmap_recovery``.

    Parameters
    ----------
    reset_distance : float
        Obstacles farther away than this are forgotten [m]; 0: all.
    affected_maps : {"both", "local", "global"}
        The window around the robot, or what is remembered of what lies behind it.
    layer_names : list of str
        The layers to clear.
    """

    reset_distance: NotNegative = 3.0
    affected_maps: AffectedMaps = "both"
    layer_names: tuple[str, ...] = LAYERS[:1]

    def __post_init__(self) -> None:
        """Check that the layers can be cleared."""
        unknown = [layer for layer in self.layer_names if layer not in LAYERS]
        if unknown:
            raise InvalidParameter(f"layer_names: there is no layer {unknown[0]!r}; known: {', '.join(LAYERS)}")


class ClearCostmapRecovery(Recovery):
    """Forgets what was seen farther away than a distance.

    Parameters
    ----------
    **parameters
        The fields of `ClearCostmapParameters`.
    """

    name: ClassVar[str] = "clear_costmap_recovery"
    purpose: ClassVar[str] = "Forgets obstacles seen farther away than reset_distance."

    def __init__(self, **parameters: Any) -> None:
        self.parameters = read_parameters(ClearCostmapParameters, self.name, parameters)

    def start(self, request: RecoveryRequest) -> None:
        """Forget."""
        if self.parameters.layer_names:
            request.clear(request.pose, self.parameters.reset_distance, self.parameters.affected_maps)

    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Be done."""
        return None
