"""Recovery ``clear_costmap_recovery``: clears observed obstacles that may be gone (``clear_costmap_recovery.cpp``)."""

from typing import Any, ClassVar

from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, read_parameters
from ppaas.recoveries.base import AffectedMaps, NotNegative, Recovery, RecoveryRequest

LAYERS = ("obstacles", "obstacle_layer")
"""ROS names of the only layer that can be cleared, the observed obstacles. The map itself stays."""


class ClearCostmapParameters(Parameters, frozen=True):
    """Parameters of ``clear_costmap_recovery``.

    Parameters
    ----------
    reset_distance : float
        Distance beyond which obstacles are cleared [m]; 0 clears all.
    affected_maps : {"both", "local", "global"}
        Whether to clear the window around the robot, the memory of obstacles outside it, or both.
    layer_names : list of str
        Layers to clear.
    """

    reset_distance: NotNegative = 3.0
    affected_maps: AffectedMaps = "both"
    layer_names: tuple[str, ...] = LAYERS[:1]

    def __post_init__(self) -> None:
        """Check that the layers can be cleared."""
        unknown = [layer for layer in self.layer_names if layer not in LAYERS]
        if unknown:
            raise InvalidParameter(f"layer_names: unknown layer {unknown[0]!r}; known: {', '.join(LAYERS)}")


class ClearCostmapRecovery(Recovery):
    """Clears observed obstacles farther away than a distance.

    Parameters
    ----------
    **parameters
        The fields of `ClearCostmapParameters`.
    """

    name: ClassVar[str] = "clear_costmap_recovery"
    purpose: ClassVar[str] = "Clears observed obstacles farther away than reset_distance."

    def __init__(self, **parameters: Any) -> None:
        self.parameters = read_parameters(ClearCostmapParameters, self.name, parameters)

    def start(self, request: RecoveryRequest) -> None:
        """Clear the obstacles."""
        if self.parameters.layer_names:
            request.clear(request.pose, self.parameters.reset_distance, self.parameters.affected_maps)

    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Return None: the behaviour is done after ``start``."""
        return None
