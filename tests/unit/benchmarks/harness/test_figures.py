"""Figures, as a table and as JSON."""

import json

import pytest

from benchmarks.harness.figures import Figure, measured, median_and_p99, median_and_worst, median_of, served_after

FIGURES = [
    median_of("plans", "REST", [0.003, 0.001, 0.002], limit=1.0),
    Figure("plans", "echo", 0.5, "ms", yardstick=True),
    Figure("fleet", "robots", 12, "robots", limit=10, floor=True, note="in time"),
]


def test_a_median_of_seconds_is_shown_in_milliseconds_with_its_range() -> None:
    assert (FIGURES[0].value, FIGURES[0].least, FIGURES[0].most) == (2.0, 1.0, 3.0)


def test_a_limit_is_an_upper_or_lower_bound() -> None:
    assert [figure.kept for figure in FIGURES] == [False, None, True]


def test_the_json_contains_every_figure() -> None:
    told = json.loads(json.dumps(measured(FIGURES).result))["figures"]
    assert [(figure["name"], figure["value"]) for figure in told] == [("REST", 2.0), ("echo", 0.5), ("robots", 12.0)]


def test_the_table_shows_values_limits_and_notes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    text = measured(FIGURES).text
    assert all(part in text for part in ("2 ms", "1–3", "≤ 1", "≥ 10", "in time"))


def test_the_limit_applies_to_median_and_p99() -> None:
    middle, tail = median_and_p99("part", "ready", [0.001 * n for n in range(1, 201)], limit=150.0)
    assert (middle.value, tail.value) == (100.5, 199.0)
    assert (middle.kept, tail.kept) == (True, False)
    assert tail.note == "of 200"


def test_the_p99_of_few_samples_is_their_maximum() -> None:
    assert median_and_p99("part", "ready", [0.1, 0.3, 0.2])[1].value == 300.0
    assert [figure.value for figure in median_and_worst("part", "x", [0.1, 0.3, 0.2], limit=500.0)] == [200.0, 300.0]


def test_commands_in_transit_at_the_fault_do_not_count_as_service() -> None:
    commands = [0.0, 0.05, 0.101, 0.102, 0.35, 0.4]  # killed at 0.1; two came from what was killed
    assert abs(served_after(commands, 0.1) - 0.25) < 1e-9


def test_a_silence_before_the_fault_is_not_counted() -> None:
    assert abs(served_after([0.0, 5.0, 5.05, 5.3], 5.06) - 0.24) < 1e-9
