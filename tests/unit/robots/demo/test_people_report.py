import json

import pytest

from robots.demo.people_score import PeopleDemoReport, PeopleFigures

GOOD = PeopleFigures(0.02, 0.98, 1, 0.97, 2, 0, 0, 1.5, 60.0)


def test_the_json_object_has_the_figures_only() -> None:
    report = PeopleDemoReport("office", 60.0, 3, 5, GOOD)
    assert json.loads(report.to_json()) == {
        "count_error_mean": 0.02,
        "count_exact": 0.98,
        "identity_switches": 1,
        "followed_fraction": 0.97,
        "handovers": 2,
        "flaps": 0,
        "contacts": 0,
    }


@pytest.mark.parametrize(
    ("change", "passed"),
    [
        ({}, True),
        ({"contacts": 1}, False),
        ({"flaps": 1}, False),
        ({"seen": 0.0}, False),
        ({"followed_fraction": 0.0}, False),
    ],
)
def test_a_demo_passes_if_people_are_followed_without_contacts_and_flaps(
    change: dict[str, float], passed: bool
) -> None:
    figures = PeopleFigures(**{**{name: getattr(GOOD, name) for name in GOOD.__struct_fields__}, **change})
    report = PeopleDemoReport("office", 60.0, 3, 5, figures)
    assert report.passed == passed
    text = "\n".join(report.lines())
    assert "98.0 % of the time" in text
    assert ("passed after 60 s" in text) == passed
