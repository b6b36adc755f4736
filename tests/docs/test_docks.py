"""The commands of docks.md work as printed, and its tables are those of the code."""

import inspect
import json
from pathlib import Path

import msgspec
import pytest

from benchmarks.building import docks as bench
from ppaas.docking import failures
from ppaas.docking.approach import BodyOutline
from ppaas.docking.detection.base import SEARCH
from ppaas.docking.detection.registry import DOCK_DETECTORS
from ppaas.docking.failures import DockingFailure
from ppaas.docking.parameters import DockingParameters, DockType
from ppaas.docking.targets import DockTargets
from ppaas.parameters import read_parameters
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, run_shell, script, table, text_of

PAGE = "docs/docks.md"


def test_the_detectors_are_those_of_the_code() -> None:
    rows = table(PAGE, "detector", "looks for", "parameters")
    assert {name for name, *_ in rows} == set(DOCK_DETECTORS.names())
    for name, purpose, parameters in rows:
        kind = DOCK_DETECTORS.load(name)
        assert kind.purpose == purpose
        taken = [each for each in inspect.signature(kind).parameters if each not in ("args", "kwargs")]
        assert set(parameters.replace("`", "").split(", ")) - {""} == set(taken), name
    assert f"`search` ({SEARCH:g} m)" in text_of(PAGE)


def test_the_parameters_are_those_of_the_code() -> None:
    rows = {name: default for name, default, _ in table(PAGE, "parameter", "default", "meaning")}
    defaults = msgspec.to_builtins(DockType())
    assert list(rows) == list(defaults)
    for name, default in rows.items():
        if name != "distance":
            value = defaults[name]
            assert default == (value if isinstance(value, str) else json.dumps(value)), name
    text = text_of(PAGE)
    assert all(f"`{name}`" in text for name in DockingParameters.__struct_fields__)


def test_the_failures_are_those_of_the_code() -> None:
    kinds = [
        each
        for each in vars(failures).values()
        if isinstance(each, type) and issubclass(each, DockingFailure) and each is not DockingFailure
    ]
    rows = [(int(code), slug) for code, slug, _ in table(PAGE, "code", "failure", "what it means")]
    assert rows == [(int(kind.code), kind.slug) for kind in kinds]


def test_the_example_is_valid() -> None:
    types: set[str] = set()
    for example in blocks(PAGE, "json"):
        parameters = read_parameters(DockingParameters, "docking_server", json.loads(example)["docking_server"])
        DockTargets(parameters, BodyOutline(0.2, 0.2, 0.2))
        types |= set(parameters.dock_types)
    assert types == {"home", "cart", "shelf"}
    carrier = json.loads(Path("docs/examples/carrier.json").read_text())
    assert carrier["parameters"] == json.loads(blocks(PAGE, "json")[1])


def test_the_numbers_of_the_bench_are_those_of_the_code() -> None:
    text = " ".join(text_of(PAGE).split())
    assert f"one charger in {1.0 / bench.FAULTY:g}".replace("20", "twenty") in text


@pytest.mark.journey
def test_a_robot_docks_by_the_commands_of_the_page(own_cloud: RunningCloud, tmp_path: Path) -> None:
    printed = run_shell(script(PAGE), tmp_path, own_cloud)
    assert "waiting for charge" in printed
    assert "set down at (7." in printed
    rows = [line.split() for line in printed.splitlines()]
    assert ["succeeded", "0", "0"] in rows
    assert ["succeeded", "0"] in rows
