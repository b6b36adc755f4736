"""Parameter files of amcl, of ROS 1 or of Nav2, alone."""

from typing import TYPE_CHECKING, Any

from ppaas.imports.parameters.amcl_rules import ROS1_POSE, ROS1_RULES
from ppaas.imports.parameters.known_names import apply_known, values_of_node
from ppaas.imports.parameters.launch_files import read_parameters
from ppaas.imports.parameters.nav2.importer import import_node
from ppaas.imports.parameters.ros_yaml import GivenValue
from ppaas.imports.parameters.rules import ParameterRule, apply_rule
from ppaas.imports.parameters.values import number
from ppaas.imports.report import ImportReport

if TYPE_CHECKING:
    from ppaas.imports.parameters.draft import Translation


def import_amcl(content: bytes, name: str) -> "Translation":
    """Translate a parameter file of amcl, of ROS 1 or of Nav2, or a launch file, into a part of a robot file.

    Raises
    ------
    InvalidParameter
        The file cannot be read as parameters.
    """
    report = ImportReport(name)
    file = read_parameters(content, report)
    node, given = values_of_node(file, lambda each: "amcl" in each, report)
    if file.is_ros2:
        return import_node("amcl", node, given, report), report
    into: Translation = ({}, report)
    apply_amcl(given, node, into)
    return into


def apply_amcl(given: dict[str, GivenValue], node: str, into: "Translation") -> None:
    """Apply the rules of amcl of ROS 1 to the parameters of its node; coordinates of its start not given are 0."""
    rest = {name: value for name, value in given.items() if name not in ROS1_POSE}
    apply_known(ROS1_RULES, rest, node, into)
    draft, report = into
    for index, name in enumerate(ROS1_POSE):
        if name in given:
            rule = ParameterRule("initial_pose", "x, y [m] and yaw [rad]", _coordinate(draft, index))
            apply_rule(rule, f"{node}.{name}" if node else name, given[name], draft, report)


def _coordinate(draft: dict[str, Any], index: int) -> Any:
    """Return a function that returns the pose with this coordinate changed."""

    def changed(value: object) -> list[float]:
        pose = list(draft.get("initial_pose", (0.0, 0.0, 0.0)))
        pose[index] = number(value)
        return pose

    return changed
