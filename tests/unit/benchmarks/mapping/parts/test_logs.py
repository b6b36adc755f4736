from pathlib import Path
from typing import Any

import pytest

from benchmarks.mapping.parts.logs import figures_of, jobs_of, measure, row
from benchmarks.mapping.parts.part import SlamOptions
from ppaas.errors import InvalidInput

ERRORS = {
    "relations": 9, "mean_m": 0.002, "std_m": 0.001, "max_m": 0.01, "mean_deg": 0.02, "std_deg": 0.01, "max_deg": 0.1,
}  # fmt: skip
ABSOLUTE = {"absolute_m": 0.004, "absolute_max_m": 0.02}


def result_of(name: str, **changed: Any) -> dict[str, Any]:
    result = {
        "log": name, "beams": 180, "scans": 100, "metres": 30.0, "minutes": 1.5, "closures": 4, "cpu_s": 1.0,
        "wall_s": 1.0, "times_real_time": 90.0, "yardstick_s": 0.5, "seconds": {"tracking": 0.05}, "peak_mib": 200.0,
        "own_mib": 20.0, "private_mib": 100.0, "false_closures": {"edges": 5, "judged": 4, "false": 1},
        "wrong_cells": 0.002,
        "stages": {"tracking": ERRORS | {"mean_m": 0.1}, "polish": ERRORS | ABSOLUTE},
    }  # fmt: skip
    return result | changed


def test_worlds_are_mapped_beside_the_logs_given_and_those_of_the_folder(tmp_path: Path) -> None:
    raw = tmp_path / "laser" / "raw"
    raw.mkdir(parents=True)
    for name in ("b.clf.bz2", "a.clf", "a.relations"):
        (raw / name).touch()
    options = SlamOptions((tmp_path / "c.log",), tmp_path)
    assert [job.name for job in jobs_of(options)] == [
        "c", "a", "b", "office 0", "office 0, sweep 0.1 s", "laboratory 0", "corridors 0",
    ]  # fmt: skip
    assert options.with_relations() == [tmp_path / "c.log", raw / "a.clf"]
    assert len(jobs_of(SlamOptions(offices=3))) == 8


def test_nothing_to_map_is_refused() -> None:
    with pytest.raises(InvalidInput, match="nothing to map"):
        measure(SlamOptions(worlds=False), lambda: None)


@pytest.mark.parametrize(
    ("options", "error"),
    [(SlamOptions((Path("no.log"),)), "no file no.log"), (SlamOptions(data=Path("no")), "has no log")],
)
def test_missing_files_are_refused(options: SlamOptions, error: str) -> None:
    with pytest.raises(InvalidInput, match=error):
        options.check()


def test_figures_of_a_log_have_the_bars_of_its_name() -> None:
    found = {figure.name: figure for figure in figures_of(result_of("mit-killian"))}
    assert (found["mit-killian: mean"].limit, found["mit-killian: largest"].limit) == (0.05, 1.0)
    assert found["mit-killian: over 0.5 m"].kept is False
    assert found["mit-killian"].limit == 250.0 and found["mit-killian"].value == pytest.approx(104.9)
    slow = {figure.name: figure for figure in figures_of(result_of("office 0, sweep 0.1 s"))}
    assert slow["office 0, sweep 0.1 s: mean"].limit == 0.006
    assert slow["office 0, sweep 0.1 s: wrong cells"].value == 0.2


@pytest.mark.parametrize(("beams", "floor"), [(181, 50.0), (360, 25.0)])
def test_lasers_with_many_beams_may_take_longer(beams: int, floor: float) -> None:
    speed = next(figure for figure in figures_of(result_of("other", beams=beams)) if figure.part == "speed")
    assert (speed.limit, speed.floor) == (floor, True)


def test_a_log_without_truth_has_figures_of_speed_only() -> None:
    result = result_of("other", stages={"polish": {}}, false_closures=None, wrong_cells=None)
    assert {figure.part for figure in figures_of(result)} == {"speed"}


def test_details_have_the_errors_after_each_stage() -> None:
    details = row(result_of("office 0"))
    assert details["relations m"] == "0.0020 ± 0.0010 (max 0.01)"
    assert details["by stage m"] == "0.1000 → 0.0020"
    assert (details["ms a scan"], details["MiB (own)"]) == ("0.50", "200 (20)")
