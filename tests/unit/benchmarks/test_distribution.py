"""Benches are registered by their own distribution, which contains no module; the wheel of ppaas has none."""

import tomllib
from importlib.metadata import EntryPoint, distribution

import pytest

import ppaas
from ppaas.distribution import NAME
from robots.cli.benches import GROUP
from tests.support.sources import ROOT, pyproject

PROJECT = tomllib.loads((ROOT / "benchmarks" / "pyproject.toml").read_text(encoding="utf-8"))["project"]
ENTRIES: dict[str, dict[str, str]] = PROJECT["entry-points"]
BENCHES = ENTRIES[GROUP]


@pytest.mark.parametrize(("name", "value"), BENCHES.items())
def test_every_bench_is_a_module_or_a_class_of_its_name(name: str, value: str) -> None:
    module, _, bench_class = value.partition(":")
    modules = (f"benchmarks.commands.{name}", f"benchmarks.{name}.command", f"benchmarks.stores.{name}")
    assert bench_class == f"{name.capitalize()}Bench" or module in modules
    bench = EntryPoint(name, value, GROUP).load()
    assert bench.HELP
    assert callable(bench.configure)
    assert callable(bench.measure)


def test_every_other_plugin_of_the_benches_can_be_loaded() -> None:
    for group in ENTRIES.keys() - {GROUP}:
        for name, value in ENTRIES[group].items():
            assert EntryPoint(name, value, group).load()


def test_every_module_of_commands_is_registered() -> None:
    folder = ROOT / "benchmarks" / "commands"
    modules = {value.partition(":")[0] for value in BENCHES.values()}
    registered = {name.rpartition(".")[2] for name in modules if name.startswith("benchmarks.commands.")}
    assert {file.stem for file in folder.glob("*.py")} - {"__init__"} == registered


def test_the_installed_benches_are_those_of_the_project() -> None:
    installed = distribution(PROJECT["name"])
    found = {
        group: {entry.name: entry.value for entry in installed.entry_points.select(group=group)} for group in ENTRIES
    }
    assert found == ENTRIES, "run make setup"
    assert installed.entry_points.groups == ENTRIES.keys()
    assert installed.version == ppaas.__version__
    assert not [file for file in installed.files or () if file.suffix == ".py"]


def test_ppaas_itself_registers_no_bench() -> None:
    assert GROUP not in pyproject()["project"]["entry-points"]
    assert GROUP not in {entry.group for entry in distribution(NAME).entry_points}
