"""What Move Base tries when it is stuck: the list it was given, or that of move_base."""

from typing import Any

from ppaas.navigation.parameters import MoveBaseParameters, RecoveryBehavior

CONSERVATIVE = RecoveryBehavior("conservative_reset", "clear_costmap_recovery")
ROTATE = RecoveryBehavior("rotate_recovery", "rotate_recovery")
AGGRESSIVE = RecoveryBehavior("aggressive_reset", "clear_costmap_recovery")


def recovery_behaviors(parameters: MoveBaseParameters) -> tuple[RecoveryBehavior, ...]:
    """Return what is tried, in order (``loadRecoveryBehaviors``, ``loadDefaultRecoveryBehaviors``)."""
    if not parameters.recovery_behavior_enabled:
        return ()
    if parameters.recovery_behaviors is not None:
        return parameters.recovery_behaviors
    if not parameters.clearing_rotation_allowed:
        return CONSERVATIVE, AGGRESSIVE
    return CONSERVATIVE, ROTATE, AGGRESSIVE, ROTATE


def recovery_defaults(parameters: MoveBaseParameters) -> dict[str, dict[str, Any]]:
    """Return what move_base presets of its own behaviours' parameters, by their names."""
    if parameters.recovery_behaviors is not None:
        return {}
    return {
        CONSERVATIVE.name: {"reset_distance": parameters.conservative_reset_dist},
        AGGRESSIVE.name: {"reset_distance": 0.0},
    }
