"""Search for all faults of a robot file by a check that stops at the first."""

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from ppaas.clone.file_faults import MOST_FAULTS, all_faults

SECTIONS = ("a", "b", "c", "d")
names = st.sampled_from(["x", "y", "z", "known"])
files = st.dictionaries(st.sampled_from(SECTIONS), st.dictionaries(names, st.booleans()))


def first_bad(file: dict[str, Any]) -> str | None:
    """Refuse the first parameter that is False, as a clone refuses one after the other."""
    for section in SECTIONS:
        for name, good in file.get("parameters", {}).get(section, {}).items():
            if not good:
                return f"parameters of {section!r}: `{name}` is bad; known: x, y, z"
    return None


@given(files)
def test_all_faults_are_found_with_the_paths_of_their_parameters(parameters: dict[str, dict[str, bool]]) -> None:
    found = all_faults({"model": "m", "parameters": parameters}, first_bad)
    bad = {f"parameters.{s}.{name}" for s, values in parameters.items() for name, good in values.items() if not good}
    assert {fault.parameter for fault in found} == bad
    assert len(found) == len(bad)
    assert all(f"`{fault.parameter.rpartition('.')[2]}` is bad" in fault.text for fault in found)


def test_a_fault_of_two_parameters_is_listed_once() -> None:
    def check(file: dict[str, Any]) -> str | None:
        dwa = {"low": 0.0, "high": 0.5} | file.get("parameters", {}).get("dwa", {})
        if dwa["low"] > dwa["high"]:
            return f"low must be at most high, {dwa['high']}"
        return "rate is bad" if "rate" in file.get("parameters", {}).get("move", {}) else None

    found = all_faults({"parameters": {"dwa": {"high": 1.0, "low": 2.0}, "move": {"rate": 0}}}, check)
    assert [fault.text for fault in found] == ["low must be at most high, 1.0", "rate is bad"]


def test_parameters_of_a_plug_in_whose_name_is_wrong_are_no_fault() -> None:
    def check(file: dict[str, Any]) -> str | None:
        name = file.get("base_local_planner", "dwa")
        if name not in ("dwa", "mppi"):
            return f"unknown controller {name!r}"
        rest = [section for section in file.get("parameters", {}) if section != name]
        return f"parameters for unknown node {rest[0]!r}" if rest else None

    found = all_faults({"base_local_planner": "mpi", "parameters": {"mppi": {}}}, check)
    assert [fault.parameter for fault in found] == ["base_local_planner"]
    [fault] = all_faults({"base_local_planner": "mppi", "parameters": {"mpi": {}}}, check)
    assert fault.parameter == "parameters.mpi"


def test_objects_of_a_list_are_told_apart() -> None:
    def check(file: dict[str, Any]) -> str | None:
        types = [each["type"] for each in file.get("parameters", {}).get("move", {}).get("list", [])]
        return next((f"unknown {kind!r}" for kind in types if kind.startswith("?")), None)

    file = {"parameters": {"move": {"list": [{"type": "?a"}, {"type": "b"}, {"type": "?c"}]}}}
    assert [fault.text for fault in all_faults(file, check)] == ["unknown '?a'", "unknown '?c'"]


def test_a_fault_of_no_single_part_and_a_search_without_time_are_reported_as_they_are() -> None:
    [fault] = all_faults({"parameters": {"a": {"x": 1}}}, lambda _: "the robot is too tall")
    assert fault == ("", "the robot is too tall")
    [fault] = all_faults({"parameters": {"a": {"x": False, "y": False}}}, first_bad, lambda: False)
    assert fault.parameter == "" and "`x` is bad" in fault.text


def test_the_list_of_faults_is_bounded() -> None:
    many = {"parameters": {"a": {f"p{number}": False for number in range(3 * MOST_FAULTS)}}}
    assert len(all_faults(many, first_bad)) == MOST_FAULTS
