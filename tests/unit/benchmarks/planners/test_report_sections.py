"""Sections of the report show ratios, aims and warnings."""

import pytest

from benchmarks.planners import report, suite


def test_speed_ups_are_shown_with_their_targets() -> None:
    measurement = {
        "grid": "random 20 % 4096²", "reached": 1000, "seconds": {"1": 2e-6, "2": 1e-6},
        "ns_per_cell": {"1": 2.0, "2": 1.0}, "again_seconds": {"1": 2e-6, "2": 1e-6},
        "beside": {"navfn": 2e-5}, "left_out": {"tcod": "not installed"},
    }  # fmt: skip
    text = report.render({"fields": [measurement]})
    assert "| random 20 % 4096² | 1 | 10 |  | 7.2 × navfn, 33 × tcod | 20 |  |" in text
    assert "| random 20 % 4096² | 2 | 20 |  | 13 × navfn, 60 × tcod | 20 |  |" in text
    assert "- tcod on random 20 % 4096²: not installed" in text


@pytest.mark.parametrize(("load", "warned"), [(0.2, False), (1.5, True)])
def test_measurements_on_a_busy_machine_are_marked(load: float, warned: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suite.os, "getloadavg", lambda: (load, 0.0, 0.0))
    text = report.render({"machine": [suite.describe() | {"quick": False}]})
    assert text.startswith("Measured on ") and ("not suitable for comparison" in text) == warned
