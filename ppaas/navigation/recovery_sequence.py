"""Recovery behaviours of Move Base: the ones in its parameters, or move_base's default list."""

from typing import Any

from ppaas.navigation.parameters import MoveBaseParameters, RecoveryBehavior

CONSERVATIVE = RecoveryBehavior("conservative_reset", "clear_costmap_recovery")
ROTATE = RecoveryBehavior("rotate_recovery", "rotate_recovery")
AGGRESSIVE = RecoveryBehavior("aggressive_reset", "clear_costmap_recovery")


def recovery_behaviors(parameters: MoveBaseParameters) -> tuple[RecoveryBehavior, ...]:
    """Return the behaviours in order (``loadRecoveryBehaviors``, ``loadDefaultRecoveryBehaviors``)."""
    if not parameters.recovery_behavior_enabled:
        return ()
    if parameters.recovery_behaviors is not None:
        return parameters.recovery_behaviors
    if not parameters.clearing_rotation_allowed:
        return CONSERVATIVE, AGGRESSIVE
    return CONSERVATIVE, ROTATE, AGGRESSIVE, ROTATE


def recovery_defaults(parameters: MoveBaseParameters) -> dict[str, dict[str, Any]]:
    """Return the parameters that move_base presets for the behaviours of its default list, by their names."""
    if parameters.recovery_behaviors is not None:
        return {}
    return {
        CONSERVATIVE.name: {"reset_distance": parameters.conservative_reset_dist},
        AGGRESSIVE.name: {"reset_distance": 0.0},
    }
