"""Fixtures of all joints: the duration of the load, and the measured figures."""

import os
from collections.abc import Callable

import pytest

_FIGURES = pytest.StashKey[list[str]]()

Figure = Callable[[str, float | str], None]


@pytest.fixture(scope="session")
def seconds() -> float:
    """Return the duration of the load on a joint [s]: `PPAAS_JOINT_SECONDS`, or 5."""
    return float(os.environ.get("PPAAS_JOINT_SECONDS", "5"))


@pytest.fixture
def figure(request: pytest.FixtureRequest) -> Figure:
    """Return a function that records a measured figure; all are printed at the end."""
    notes = request.config.stash.setdefault(_FIGURES, [])

    def note(name: str, value: float | str) -> None:
        text = f"{value:.4g}" if isinstance(value, float) else value
        notes.append(f"{request.node.name}: {name} = {text}")

    return note


def pytest_terminal_summary(terminalreporter, config: pytest.Config) -> None:
    figures = config.stash.get(_FIGURES, [])
    if figures:
        terminalreporter.section("measured at the joints")
        for line in figures:
            terminalreporter.line(line)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    strain = float(os.environ.get("PPAAS_JOINT_SECONDS", "5"))
    for item in items:
        if item.get_closest_marker("joint"):
            item.add_marker(pytest.mark.timeout(120 + 4 * strain))
