from pathlib import Path

import pytest

from benchmarks.harness.figures import Figure, PartResult
from benchmarks.mapping.parts import steps, suite
from benchmarks.mapping.parts.lifelong import figure_of
from benchmarks.mapping.parts.part import SlamOptions
from benchmarks.mapping.parts.suite import _points, write_stages
from benchmarks.mapping.parts.volumes import figures_of, row
from benchmarks.mapping.small_worlds import ring_drive
from ppaas.errors import InvalidInput, PPaaSError, Unavailable
from ppaas.maps.generate import office


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


HOUR = {"memory_mb": 200.0, "key_frames": 900}


def test_the_growth_is_that_of_the_last_hour():
    figure = figure_of([HOUR | {"hour": 1}, HOUR | {"hour": 2, "memory_mb": 203.5, "key_frames": 910}])
    assert (figure.value, figure.kept) == (3.5, False)
    assert figure.note.endswith("from 900 to 910 key frames")


SECONDS = {"points": 1.0, "tracking": 2.0, "closures": 1.5, "solver": 0.5, "refinement": 3.0, "polish": 1.0}
ERRORS = {"tracking": 0.1, "closures": 0.03, "refinement": 0.02, "polish": 0.01}
TIMES = {"cpu_s": 5.0, "wall_s": 10.0}
STAGES = {name: {"mean_m": error} for name, error in ERRORS.items()}


def test_error_and_time_after_each_stage_are_drawn(tmp_path):
    without: dict[str, dict[str, float]] = {name: {} for name in STAGES}
    results = [
        {"log": "a", "seconds": SECONDS, **TIMES, "stages": STAGES},
        {"log": "b", "seconds": SECONDS, **TIMES, "stages": without},
    ]
    path = tmp_path / "stages.png"
    write_stages(path, results)
    assert path.read_bytes().startswith(b"\x89PNG")


def test_a_stage_takes_the_time_of_its_parts_after_that_of_the_stages_before():
    assert _points({"seconds": SECONDS, **TIMES, "stages": STAGES}) == [
        (1.5, 0.1),
        (2.5, 0.03),
        (4.0, 0.02),
        (4.5, 0.01),
    ]


def test_steps_are_measured_beside_their_baselines(monkeypatch):
    monkeypatch.setattr(steps, "SEARCHES", 2)
    monkeypatch.setattr(steps, "TARGET", 8)
    frames, latencies = steps.drive(ring_drive().log.first(250))
    scans, searched = latencies.result(), steps.searches(frames)
    assert (scans["count"], searched["count"]) == (250, 2)
    assert 0.0 < scans["mean_ms"] <= scans["max_ms"]
    # The window contains the true motion, and the older scans show the place.
    assert searched["least_score"] > 0.8
    assert steps.row(searched)["step"] == "search of 4 m × 90°"


def test_layers_are_measured_on_the_whole_map(monkeypatch):
    monkeypatch.setattr(steps, "BUILDS", 2)
    built = steps.layers(office(0, 14.0, 11.0))
    assert (built["step"], built["count"]) == ("layers of 280 × 220 cells", 2)
    assert 0.0 < built["mean_ms"] <= built["max_ms"]


RESULT = {
    "method": "blocks", "threads": 1, "points": 1000, "points_per_s": 3_000_000, "points_per_cpu_s": 4_000_000,
    "wall_s": 0.1, "voxels": 50, "equal_log_odds": 1.0, "equal_occupancy": 0.998,
}  # fmt: skip


def test_one_thread_is_measured_by_its_cpu_time_and_two_by_the_clock():
    rate, equal = figures_of(RESULT, bars=True)
    assert (rate.value, rate.limit, rate.kept) == (4_000_000, 1.1e6, True)
    assert (equal.value, equal.kept) == (99.8, False)
    (rate,) = figures_of(RESULT | {"threads": 2}, bars=True)
    assert (rate.value, rate.limit) == (3_000_000, 2.0e6)
    assert figures_of(RESULT, bars=False)[0].limit is None
    assert row(RESULT)["equal occupancy"] == "99.800 %"


def test_the_insertion_of_octomap_is_a_baseline():
    baseline = {name: value for name, value in RESULT.items() if name not in ("threads", "equal_occupancy")}
    (figure,) = figures_of(baseline, bars=True)
    assert figure.yardstick and figure.limit is None
    assert row(baseline)["equal occupancy"] == ""
