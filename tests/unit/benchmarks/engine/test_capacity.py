"""Figures of the capacity bench."""

from benchmarks.engine.capacity import capacity_figures


def test_the_number_of_containers_has_the_error_of_the_next() -> None:
    figures = capacity_figures(3, [0.1, 0.2], ["Unavailable: no machine has room"], [0.01], [12_000_000, 14_000_000])
    first = figures[0]
    assert (first.value, first.kept) == (2, False)
    assert "no machine has room" in first.note
    assert {figure.name: figure.value for figure in figures}["memory of all"] == 26.0


def test_without_an_answer_there_are_no_other_figures() -> None:
    assert [figure.value for figure in capacity_figures(3, [], ["Unavailable: why"], [], [])] == [0]
