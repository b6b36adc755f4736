"""Rules by which foreign parameters become a robot file."""

from typing import Any

from ppaas.imports.parameters.ros_yaml import GivenValue
from ppaas.imports.parameters.rules import ParameterRule, apply_rule
from ppaas.imports.report import ImportOutcome, ImportReport, ReportEntry


def applied(rule: ParameterRule, value: Any) -> tuple[dict[str, Any], ReportEntry]:
    draft: dict[str, Any] = {"map": "office"}
    report = ImportReport("f.yaml")
    apply_rule(rule, "amcl.alpha1", GivenValue(value, 7), draft, report)
    (entry,) = report.entries
    return draft, entry


def test_the_same_name_is_taken() -> None:
    draft, entry = applied(ParameterRule("parameters.amcl.alpha1"), 0.2)
    assert draft == {"map": "office", "parameters": {"amcl": {"alpha1": 0.2}}}
    place = "parameters.amcl.alpha1"
    assert entry == ReportEntry("amcl.alpha1", ImportOutcome.TAKEN, place, 7, place)


def test_a_conversion_is_a_translation() -> None:
    draft, entry = applied(ParameterRule("parameters.amcl.odom_alpha1", "halved", lambda value: value / 2), 0.2)
    assert draft["parameters"] == {"amcl": {"odom_alpha1": 0.1}}
    assert entry.outcome is ImportOutcome.TRANSLATED
    assert entry.text == "parameters.amcl.odom_alpha1 = 0.1: halved"


def test_a_parameter_without_effect_changes_nothing() -> None:
    draft, entry = applied(ParameterRule(text="the clone has no threads"), 2)
    assert draft == {"map": "office"}
    assert (entry.outcome, entry.text) == (ImportOutcome.NO_EFFECT, "the clone has no threads")


def test_a_value_that_cannot_be_converted_is_refused() -> None:
    draft, entry = applied(ParameterRule("parameters.amcl.alpha1", convert=float), "fast")
    assert draft == {"map": "office"}
    assert (entry.outcome, entry.line) == (ImportOutcome.REFUSED, 7)
    assert "fast" in entry.text
