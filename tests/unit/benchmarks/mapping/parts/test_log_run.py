"""Runs of the mapping bench."""

from pathlib import Path

import pytest

from benchmarks.mapping.parts import logs
from benchmarks.mapping.parts.logs import SlamJob, row, run
from benchmarks.mapping.parts.mapped import mapped
from benchmarks.mapping.small_worlds import walls
from tests.support.world.log_text import carmen_log, relations_text
from tests.support.world.ring_drive import ring_drive


@pytest.fixture(autouse=True)
def short_warm_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(logs, "ring_drive", lambda: ring_drive().first(10))


def test_a_log_is_scored_by_the_relations_beside_it(tmp_path: Path) -> None:
    drive = ring_drive().first(60)
    (tmp_path / "ring.clf").write_text(carmen_log(drive))
    (tmp_path / "ring.relations").write_text(relations_text(drive, 10))
    result = run(SlamJob(tmp_path / "ring.clf"), tmp_path)
    assert (result["log"], result["scans"]) == ("ring", 60)
    assert result["stages"]["polish"]["relations"] == 50
    assert result["stages"]["polish"]["mean_m"] < 0.02
    assert result["metres"] == pytest.approx(drive.metres, rel=0.05)
    assert "absolute_m" not in result["stages"]["polish"]
    assert row(result)["absolute m"] == ""


def test_a_log_without_relations_has_no_errors(tmp_path: Path) -> None:
    (tmp_path / "ring.clf").write_text(carmen_log(ring_drive().first(20)))
    result = run(SlamJob(tmp_path / "ring.clf"), tmp_path)
    assert result["stages"]["polish"] == {}
    assert row(result)["relations m"] == row(result)["by stage m"] == ""


def test_a_simulated_drive_has_relations_and_absolute_errors(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(logs, "drive_of", lambda *_: ring_drive())
    monkeypatch.setattr(logs, "walls_of", lambda *_: walls())
    result = run(SlamJob(seed=3, sweep=0.1), tmp_path)
    assert result["log"] == "office 3, sweep 0.1 s"
    assert result["stages"]["polish"]["absolute_m"] < 0.02
    assert result["times_real_time"] > 0.0
    assert result["false_closures"]["judged"] == result["closure_edges"] > 0
    assert result["false_closures"]["false"] == 0
    assert result["wrong_cells"] < 0.01
    assert 0.0 < result["own_mib"] < result["peak_mib"]
    kept = mapped(tmp_path, result["log"], pytest.fail)
    assert len(kept.mapping.frames) == result["key_frames"] and len(kept.poses) == result["scans"]
