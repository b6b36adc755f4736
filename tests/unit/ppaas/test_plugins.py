"""Plug-ins: those that a process may load, their names and their parameters."""

from importlib.metadata import EntryPoint, distribution

import pytest

from ppaas import plugins
from ppaas.distribution import NAME, BrokenPlugin, is_own
from ppaas.errors import InvalidParameter, NotFound, NotPermitted
from ppaas.planners.base import Planner
from ppaas.planners.grid.astar import AStar
from ppaas.planners.lattice.planner import Lattice
from ppaas.plugins import PluginRegistry, permit_only, permitted, taken_by

GROUP = "ppaas.planners"


class Installed:
    """A distribution as entry points refer to it: an object with a name."""

    version = "1.2"

    def __init__(self, name: str) -> None:
        self.name = name


def entry(name: str, of: str, value: str = f"{AStar.__module__}:{AStar.__name__}") -> EntryPoint:
    made = EntryPoint(name, value, GROUP)
    vars(made).update(dist=Installed(of))
    return made


@pytest.fixture
def registry(monkeypatch: pytest.MonkeyPatch) -> PluginRegistry[Planner]:
    entries = [
        entry("ours", NAME), entry("theirs", "another"), entry("more", "another"), entry("ours", "another"),
        entry("missing", "another", "no_such_module:Planner"), entry("no_planner", "another", "json:loads"),
        entry("failing", "another", f"{__name__}:Failing"), entry("ours_missing", NAME, "no_such_module:Planner"),
    ]  # fmt: skip
    monkeypatch.setattr(plugins, "entry_points", lambda group: entries)
    return PluginRegistry(GROUP, "planner", Planner, {})  # type: ignore[type-abstract]


def test_a_process_outside_the_cloud_loads_all_installed_plugins(registry: PluginRegistry[Planner]) -> None:
    plugins._permitted = None
    assert {"more", "ours", "theirs"} <= set(registry.names())
    assert permitted() is None
    assert registry.load("theirs") is AStar


def test_cloud_loads_own_and_allowed_plugins(registry: PluginRegistry[Planner]) -> None:
    permit_only([f"{GROUP}:theirs"])
    assert registry.names() == ("ours", "ours_missing", "theirs")
    assert "more" in registry and "nowhere" not in registry
    assert permitted() == (f"{GROUP}:theirs",)
    assert registry.load("ours") is registry.load("theirs") is AStar


def test_plugin_not_allowed_is_refused_with_the_option(registry: PluginRegistry[Planner]) -> None:
    permit_only([f"{GROUP}:theirs", "ppaas.controllers:more"])
    with pytest.raises(NotPermitted, match=r"planner 'more' is installed.*ppaas up --allow ppaas\.planners:more"):
        registry.create("more", {})
    with pytest.raises(NotFound, match=r"known: ours, ours_missing, theirs$"):
        registry.load("nowhere")


def test_own_plugin_is_not_replaced_by_another_of_its_name(registry: PluginRegistry[Planner]) -> None:
    permit_only([])
    assert registry._entries["ours"].dist.name == NAME  # type: ignore[union-attr]
    assert registry.load("ours") is AStar


@pytest.mark.parametrize("name", ["mine", "ppaas.planners", "ppaas.planners:", "os:system", ":", ""])
def test_an_invalid_name_is_refused(name: str) -> None:
    with pytest.raises(InvalidParameter, match="group:name"):
        permit_only([name])


def test_all_plugins_of_the_project_are_recognized_as_own() -> None:
    entries = [entry for entry in distribution(NAME).entry_points if entry.group == GROUP]
    assert entries
    assert all(is_own(entry) for entry in entries)


class Picky(AStar):
    """Planner whose constructor refuses a value as Python code does."""

    def __init__(self, weight: float = 1.0) -> None:
        super().__init__()
        if weight < 1.0:
            raise ValueError("weight must be at least 1")


def test_a_value_that_a_plugin_refuses_is_an_invalid_parameter(
    registry: PluginRegistry[Planner], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registry, "load", lambda _name: Picky)
    assert isinstance(registry.create("picky", {"weight": 2}), Picky)
    with pytest.raises(InvalidParameter, match="planner 'picky': weight must be at least 1"):
        registry.create("picky", {"weight": 0.5})


class Failing(AStar):
    """Planner whose constructor fails."""

    def __init__(self) -> None:
        super().__init__()
        raise KeyError("table")


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("missing", "cannot be loaded: ModuleNotFoundError: No module named 'no_such_module'"),
        ("no_planner", "is not a subclass of Planner"),
        ("failing", "cannot be created: KeyError: 'table'"),
    ],
)
def test_a_plugin_of_another_distribution_that_fails_is_named_with_its_entry_point(
    registry: PluginRegistry[Planner], name: str, reason: str
) -> None:
    plugins._permitted = None
    words = rf"^planner '{name}' \(entry point '{name}' = .* of another 1\.2\) {reason}$"
    with pytest.raises(BrokenPlugin, match=words):
        registry.create(name, {})


def test_an_own_plugin_that_lacks_a_package_reports_the_package(registry: PluginRegistry[Planner]) -> None:
    with pytest.raises(ModuleNotFoundError, match="no_such_module"):
        registry.load("ours_missing")


def test_a_plugin_is_offered_only_what_it_takes() -> None:
    assert taken_by(Picky, {"weight": 2.0, "height": 1.0}) == {"weight": 2.0}
    assert taken_by(Lattice, {"weight": 2.0}) == {"weight": 2.0}  # it has **parameters, and checks them itself
