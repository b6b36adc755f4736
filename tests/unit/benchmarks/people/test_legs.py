"""Part of the people bench that measures the leg detector."""

import pytest

from benchmarks.people import legs
from benchmarks.people.options import PeopleOptions


def test_the_part_reports_recall_by_distance_and_precision(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("SECONDS", 2.5), ("OFFICE", (14.0, 11.0)), ("PEOPLE", 14)):
        monkeypatch.setattr(legs, name, value)
    figures, rows, [counts] = legs.measure(PeopleOptions(quick=True, seed=2))
    assert [figure.unit for figure in figures] == ["", "", "m", "ms"]
    assert [row["distance"] for row in rows] == ["0–1 m", "1–2 m", "2–3 m", "3–4 m"]
    people = sum(int(row["people"]) for row in rows)
    assert people > 0
    assert people == sum(number for name, number in counts.items() if name.startswith(("seen", "missed")))
    assert figures[0].value > 0.5
