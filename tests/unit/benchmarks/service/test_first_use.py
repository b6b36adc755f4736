"""Figures of the first use of a cloud."""

from benchmarks.service.first_use import _figures


def test_figures_are_named_by_what_a_user_waits_for() -> None:
    figures = _figures("with a wheel", {"up": 1.5, "jps": 2.0, "drives": 7.0, "lost": 0.0}, within_limits=True)
    assert [figure.name for figure in figures] == [
        "ppaas up, ready, with a wheel",
        "first path of jps, with a wheel",
        "first cmd_vel of a robot, with a wheel",
        "requests lost, with a wheel",
    ]
    assert all(figure.kept for figure in figures)


def test_a_lost_request_or_a_late_path_breaks_a_limit() -> None:
    figures = _figures("with a wheel", {"jps": 5.5, "drives": 8.5, "lost": 1.0}, within_limits=True)
    assert [figure.kept for figure in figures] == [False] * 3


def test_a_yardstick_has_no_limit() -> None:
    (figure,) = _figures("again", {"jps": 9.0}, yardstick=True)
    assert (figure.kept, figure.yardstick) == (None, True)
