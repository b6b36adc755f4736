"""Names that rules know, names like them, values that a launch file fills in, and nodes."""

from collections.abc import Mapping

import pytest

from ppaas.imports.parameters.draft import Translation
from ppaas.imports.parameters.known_names import apply_known, refuse_unknown, values_of_node
from ppaas.imports.parameters.ros_yaml import GivenValue, read_parameter_file
from ppaas.imports.parameters.rules import ParameterRule
from ppaas.imports.report import ImportReport
from tests.support.imported_parameters import entry_of, outcomes, refused

RULES = {
    "max_vel_x": ParameterRule("parameters.dwa.max_vel_x"),
    "top_speed": ParameterRule("parameters.dwa.max_vel_x"),
    "debug": ParameterRule(text="it is for debugging"),
}


def applied(values: Mapping[str, object]) -> Translation:
    into: Translation = ({}, ImportReport("f.yaml"))
    given = {name: GivenValue(value, line) for line, (name, value) in enumerate(values.items(), 1)}
    apply_known(RULES, given, "driver", into)
    return into


def of_node(text: str) -> tuple[str, dict[str, object], Translation]:
    into: Translation = ({}, ImportReport("f.yaml"))
    file = read_parameter_file(text.encode())
    name, values = values_of_node(file, lambda each: "amcl" in each, into[1])
    return name, {each: given.value for each, given in values.items()}, into


def test_an_unknown_name_is_refused_with_the_nearest_one() -> None:
    into = applied({"max_vel_X": 1.0, "nothing_like_it": 2})
    assert into[0] == {}
    assert refused(into) == [
        "unknown parameter; did you mean 'max_vel_x'?",
        "unknown parameter; look it up in the tables of parameters, and leave it out",
    ]


def test_a_value_in_the_place_of_a_section_is_refused_with_its_names() -> None:
    report = ImportReport("f")
    refuse_unknown("amcl.start", "start", ["start.x", "start.y", "started"], 3, report)
    assert [entry.text for entry in report.entries] == ["it must be a section, with x, y"]


def test_names_that_every_node_has_are_known() -> None:
    into = applied({"use_sim_time": True, "qos_overrides./scan.subscription.depth": 5})
    assert set(outcomes(into).values()) == {"no effect"}


@pytest.mark.parametrize("value", ["$(find pkg)/x.yaml", "$(var speed)", None])
def test_a_value_that_a_launch_file_fills_in_is_refused(value: object) -> None:
    into = applied({"max_vel_x": value, "debug": value})
    assert into[0] == {}
    assert outcomes(into) == {"driver.max_vel_x": "refused", "driver.debug": "no effect"}


def test_of_two_names_of_one_place_the_later_wins_and_the_report_says_so() -> None:
    into = applied({"max_vel_x": 0.5, "top_speed": 0.3})
    assert into[0] == {"parameters": {"dwa": {"max_vel_x": 0.3}}}
    assert entry_of(into, "driver.max_vel_x").text == "driver.top_speed sets parameters.dwa.max_vel_x, too, and wins"
    assert outcomes(into) == {"driver.max_vel_x": "no effect", "driver.top_speed": "translated"}


def test_a_number_without_a_point_is_a_number_as_in_ros() -> None:
    assert applied({"max_vel_x": "5e-1"})[0] == {"parameters": {"dwa": {"max_vel_x": 0.5}}}


def test_parameters_for_all_nodes_hold_unless_the_node_has_its_own() -> None:
    nodes = {"/**": "{a: 1, b: 2}", "/r1/amcl": "{a: 3}", "other": "{c: 4}"}
    name, values, into = of_node("".join(f"{node}:\n  ros__parameters: {each}\n" for node, each in nodes.items()))
    assert (name, values) == ("r1/amcl", {"a": 3, "b": 2})
    assert entry_of(into, "a").text == "r1/amcl sets it, too, and wins"
    assert entry_of(into, "other").text == "these are the parameters of another node"


def test_the_only_node_is_meant_whatever_its_name() -> None:
    assert of_node("mine:\n  ros__parameters: {a: 1}\n")[:2] == ("mine", {"a": 1})


def test_parameters_outside_any_node_are_those_of_the_program() -> None:
    assert of_node("a: 1\nb: 2\n")[:2] == ("", {"a": 1, "b": 2})


def test_a_name_that_occurs_twice_is_reported() -> None:
    _, values, into = of_node("amcl:\n  ros__parameters:\n    a: 1\n    a: 2\n")
    assert values == {"a": 2}
    twice = entry_of(into, "amcl.a")
    assert (twice.text, twice.line) == ("given before, too: that value has no effect, this one counts", 4)


def test_suggestions_do_not_make_a_large_file_slow(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr("ppaas.imports.report.nearest_name", lambda name, *_: asked.append(name) or None)
    applied({f"unknown_{number}": number for number in range(2000)})
    assert 0 < len(asked) < 500
