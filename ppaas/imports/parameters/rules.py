"""Rules by which the parameters of another program become a robot file."""

from collections.abc import Callable, Mapping
from typing import Any

import msgspec

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.ros_yaml import GivenValue
from ppaas.imports.report import ImportReport

Convert = Callable[[Any], Any]


class ParameterRule(msgspec.Struct, frozen=True):
    """What becomes of one parameter.

    Parameters
    ----------
    to : str
        Dotted place in the robot file: ``base_local_planner``, ``parameters.move_base.controller_frequency``. Empty:
        the parameter has no effect.
    text : str
        Why it has no effect, or what the translation does, for the report and the table of the documentation.
    convert : callable, optional
        Function that returns the translated value, or None for a value that has no effect, such as a limit of 0 that
        means none. It raises ``InvalidParameter`` or ``ValueError`` for a value that cannot be translated.
    """

    to: str = ""
    text: str = ""
    convert: Convert | None = None


ParameterRules = Mapping[str, ParameterRule]
"""Rules by the dotted names of the parameters."""


def same(place: str, *names: str, convert: Convert | None = None) -> dict[str, ParameterRule]:
    """Return rules of parameters that have the same names below a place, which ends with a dot."""
    return {name: ParameterRule(place + name, convert=convert) for name in names}


def renamed(place: str, *, convert: Convert | None = None, **names: str) -> dict[str, ParameterRule]:
    """Return rules of parameters that have the given names below a place, which ends with a dot."""
    return {name: ParameterRule(place + own, convert=convert) for name, own in names.items()}


def without_effect(reason: str, *names: str) -> dict[str, ParameterRule]:
    """Return rules of parameters that have no effect, all for one reason; a text may name several of them."""
    return {name: ParameterRule(text=reason) for text in names for name in text.split()}


def apply_rule(rule: ParameterRule, part: str, given: GivenValue, draft: dict[str, Any], report: ImportReport) -> None:
    """Apply a rule to one parameter: write it into the draft of a robot file, and report it.

    Parameters
    ----------
    rule : ParameterRule
    part : str
        Name of the parameter in the report, with its node.
    given : GivenValue
    draft : dict
        Robot file as a tree, which is changed.
    report : ImportReport
    """
    if not rule.to:
        report.without_effect(part, rule.text, given.line)
        return
    try:
        value = given.value if rule.convert is None else rule.convert(given.value)
    except (InvalidParameter, ValueError, TypeError) as error:
        report.refused(part, str(error), given.line)
        return
    if value is None:
        report.without_effect(part, f"{given.value!r} sets nothing", given.line)
        return
    put(draft, rule.to, value)
    same_name = part.rpartition(".")[2] == rule.to.rpartition(".")[2]
    if same_name and not rule.text and value == given.value:
        report.taken(part, rule.to, given.line, to=rule.to)
    else:
        text = f"{rule.to} = {value!r}" + (f": {rule.text}" if rule.text else "")
        report.translated(part, text, given.line, to=rule.to)


def put(draft: dict[str, Any], place: str, value: Any) -> None:
    """Set the value at a dotted place of a robot file; the sections of ``parameters`` are made."""
    *above, name = place.split(".")
    table = draft
    for each in above:
        table = table.setdefault(each, {})
    table[name] = value
