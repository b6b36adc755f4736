"""Rules of the outline of a robot, which costmaps of ROS 1 and of Nav2 name alike."""

from typing import Any

from ppaas.imports.parameters.rules import ParameterRule
from ppaas.imports.parameters.values import corners, unless_zero


def _corners_if_any(value: Any) -> list[list[float]] | None:
    """Return the corners of a footprint; None for an empty one, beside which the radius counts."""
    return corners(value) if value and value != "[]" else None


OUTLINE_RULES: dict[str, ParameterRule] = {
    "robot_radius": ParameterRule("parameters.global_costmap.robot_radius", convert=unless_zero),
    "footprint": ParameterRule("parameters.global_costmap.footprint", convert=_corners_if_any),
}
"""Rules by the names of the parameters; both costmaps of a clone have the outline of the global one."""
