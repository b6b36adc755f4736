"""Parameters of the costmaps of ROS 1, with those of their layers and sources of observations."""

from typing import TYPE_CHECKING

from ppaas.imports.parameters.known_names import apply_once, is_left_open, refuse_unknown
from ppaas.imports.parameters.ros1.costmap_rules import BOTH, COMMON_RULES, LOCAL_RULES
from ppaas.imports.parameters.ros1.sections import Section, layer_rule_name
from ppaas.imports.parameters.ros_yaml import GivenValue
from ppaas.imports.parameters.rules import ParameterRules
from ppaas.imports.report import ImportOutcome

if TYPE_CHECKING:
    from ppaas.imports.parameters.draft import Translation


def apply_costmap(rules: ParameterRules, section: Section, into: "Translation") -> None:
    """Apply the rules of a costmap to its section, or to that of a layer."""
    for name, given in section.values.items():
        apply_costmap_value(rules, section.prefix + name, given, into)


def apply_costmap_value(rules: ParameterRules, part: str, given: GivenValue, into: "Translation") -> None:
    """Apply the rule of a costmap to a value, which may be one of a layer or of a source of observations."""
    report = into[1]
    short = layer_rule_name(part, rules)
    rule = rules.get(short)
    if rule is None:
        refuse_unknown(part, short, rules, given.line, report)
    elif not rule.to:
        report.without_effect(part, rule.text, given.line)
    elif not is_left_open(part, given, report):
        apply_once(rule, part, given, into)
        if rules is COMMON_RULES and short in BOTH:
            apply_once(LOCAL_RULES[short], part, given, into)


def drop_radius(translations: "list[Translation]") -> None:
    """Leave out the radius of a robot that has a footprint, too, as costmap_2d does."""
    costmaps = [draft.get("parameters", {}).get("global_costmap", {}) for draft, _ in translations]
    if any("footprint" in costmap for costmap in costmaps):
        for costmap, (_, report) in zip(costmaps, translations, strict=True):
            if costmap.pop("robot_radius", None) is not None:
                place = "parameters.global_costmap.robot_radius"
                report.withdraw(place, ImportOutcome.NO_EFFECT, "footprint is given, too, and wins")
