"""Figures of the capacity bench."""

from benchmarks.engine.capacity import crowd_figures


def test_what_stopped_a_crowd_is_told_beside_how_far_it_came() -> None:
    figures = crowd_figures(3, [0.1, 0.2], ["Unavailable: no machine has room"], [0.01], [12_000_000, 14_000_000])
    first = figures[0]
    assert (first.value, first.kept) == (2, False)
    assert "no machine has room" in first.note
    assert {figure.name: figure.value for figure in figures}["memory of all"] == 26.0


def test_a_crowd_of_which_none_answers_has_no_other_figures() -> None:
    assert [figure.value for figure in crowd_figures(3, [], ["Unavailable: why"], [], [])] == [0]
