"""Two nodes of one graph answer each other."""

from benchmarks.engine.messages import in_one_container


def test_each_round_is_timed() -> None:
    seconds = in_one_container(20)
    assert len(seconds) == 20
    assert all(0.0 < second < 1.0 for second in seconds)
