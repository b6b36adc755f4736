"""Recovery behaviours and their order."""

import pytest

from ppaas.navigation.parameters import MoveBaseParameters, RecoveryBehavior, recovery_behaviors, recovery_defaults

OWN = (RecoveryBehavior("back", "back_up"), RecoveryBehavior("rest", "wait"))


@pytest.mark.parametrize(
    ("parameters", "names"),
    [
        ({}, ["conservative_reset", "rotate_recovery", "aggressive_reset", "rotate_recovery"]),
        ({"clearing_rotation_allowed": False}, ["conservative_reset", "aggressive_reset"]),
        ({"recovery_behavior_enabled": False}, []),
        ({"recovery_behaviors": OWN}, ["back", "rest"]),
        ({"recovery_behaviors": OWN, "clearing_rotation_allowed": False}, ["back", "rest"]),
        ({"recovery_behaviors": OWN, "recovery_behavior_enabled": False}, []),
        ({"recovery_behaviors": ()}, []),
    ],
)
def test_recovery_behaviors_are_the_given_ones_or_move_base_defaults(parameters, names):
    assert [each.name for each in recovery_behaviors(MoveBaseParameters(**parameters))] == names


def test_move_base_presets_only_its_own_behaviours():
    own = recovery_defaults(MoveBaseParameters(conservative_reset_dist=2.0))
    assert own == {"conservative_reset": {"reset_distance": 2.0}, "aggressive_reset": {"reset_distance": 0.0}}
    assert recovery_defaults(MoveBaseParameters(recovery_behaviors=OWN)) == {}
