"""Figures of the capacity bench."""

from benchmarks.engine.capacity import capacity_figures


def test_the_number_of_containers_is_reported_with_the_first_error() -> None:
    figures = capacity_figures(3, [0.1, 0.2], ["Unavailable: no machine has room"], [0.01], [12_000_000, 14_000_000])
    first = figures[0]
    assert (first.value, first.kept) == (2, False)
    assert "no machine has room" in first.note
    assert {figure.name: figure.value for figure in figures}["memory of all"] == 26.0


def test_other_figures_are_omitted_if_no_container_answers() -> None:
    assert [figure.value for figure in capacity_figures(3, [], ["Unavailable: why"], [], [])] == [0]
