from pathlib import Path

import pytest

from benchmarks.harness.figures import Figure, PartResult
from benchmarks.mapping.parts import suite
from benchmarks.mapping.parts.part import SlamOptions
from ppaas.errors import InvalidInput, PPaaSError, Unavailable


class _Progress:
    """Progress display that remembers what it shows."""

    def __init__(self) -> None:
        self.shown: list[str] = []

    def add_task(self, name: str, total: int) -> int:
        return 0

    def update(self, task: int, description: str) -> None:
        self.shown.append(description)

    def advance(self, task: int) -> None:
        pass


def measured(monkeypatch: pytest.MonkeyPatch, error: PPaaSError | None) -> dict[str, PartResult]:
    """Measure two parts in this process; the second one may fail."""

    def run_all(part, options, processes, done, *, fresh):  # type: ignore[no-untyped-def]
        assert options[0].folder.is_dir() and fresh
        if error is not None and part is suite.PARTS["push"]:
            raise error
        return [PartResult([Figure("steps", "step", 1.0, "ms")], [], [])]

    monkeypatch.setattr(suite, "run_all", run_all)
    progress = _Progress()
    found = suite.measure(SlamOptions(), ("push", "steps"), progress)  # type: ignore[arg-type]
    assert progress.shown == list(found) == ["steps", "push"]
    return found


def test_only_the_chosen_parts_are_measured_in_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    assert measured(monkeypatch, None)["steps"].figures[0].value == 1.0


def test_a_part_that_fails_misses_its_bar_and_the_others_are_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    (figure,) = measured(monkeypatch, Unavailable("the cloud does not start"))["push"].figures
    assert figure.kept is False and figure.note == "the cloud does not start"


def test_wrong_input_ends_the_bench(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InvalidInput):
        measured(monkeypatch, InvalidInput("not a log"))
    with pytest.raises(InvalidInput, match="no file"):
        suite.measure(SlamOptions((Path("a.log"),)), (), _Progress())  # type: ignore[arg-type]
