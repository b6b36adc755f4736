"""Plug-ins: those that a process may load, their names and their parameters."""

from importlib.metadata import EntryPoint, distribution

import pytest

from ppaas import plugins
from ppaas.distribution import NAME
from ppaas.errors import InvalidParameter, NotFound, NotPermitted
from ppaas.planners.base import Planner
from ppaas.planners.grid.astar import AStar
from ppaas.plugins import PluginRegistry, permit_only, permitted

GROUP = "ppaas.planners"


class Installed:
    """A distribution as entry points refer to it: an object with a name."""

    def __init__(self, name: str) -> None:
        self.name = name


def entry(name: str, of: str) -> EntryPoint:
    made = EntryPoint(name, f"{AStar.__module__}:{AStar.__name__}", GROUP)
    vars(made).update(dist=Installed(of))
    return made


@pytest.fixture
def registry(monkeypatch: pytest.MonkeyPatch) -> PluginRegistry[Planner]:
    entries = [entry("ours", NAME), entry("theirs", "another"), entry("more", "another"), entry("ours", "another")]
    monkeypatch.setattr(plugins, "entry_points", lambda group: entries)
    return PluginRegistry(GROUP, "planner", Planner, {})  # type: ignore[type-abstract]


def test_a_process_outside_the_cloud_loads_all_installed_plugins(registry: PluginRegistry[Planner]) -> None:
    plugins._permitted = None
    assert registry.names() == ("more", "ours", "theirs")
    assert permitted() is None
    assert registry.load("theirs") is AStar


def test_cloud_loads_own_and_allowed_plugins(registry: PluginRegistry[Planner]) -> None:
    permit_only([f"{GROUP}:theirs"])
    assert registry.names() == ("ours", "theirs")
    assert permitted() == (f"{GROUP}:theirs",)
    assert registry.load("ours") is registry.load("theirs") is AStar


def test_plugin_not_allowed_is_refused_with_the_option(registry: PluginRegistry[Planner]) -> None:
    permit_only([f"{GROUP}:theirs", "ppaas.controllers:more"])
    with pytest.raises(NotPermitted, match=r"planner 'more' is installed.*ppaas up --allow ppaas\.planners:more"):
        registry.create("more", {})
    with pytest.raises(NotFound, match=r"known: ours, theirs$"):
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
    assert all(plugins._is_own(entry) for entry in entries)


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
