"""``ppaas bench plans`` on a few plans."""

import json
from pathlib import Path

import pytest
from rich.progress import Progress

from benchmarks.commands.plans import rows_of
from benchmarks.stores import plans
from ppaas.errors import Conflict
from robots.cli.main import main
from storage.urls.opening import open_store


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("bench")


def test_the_measurements_are_returned_as_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "plans", "--plans", "200", "--cache", str(folder), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    [size] = result["sizes"]
    assert size["plans"] == 200
    assert size["kept_once"] > 1.0
    assert 100 < size["waypoints_a_plan"] < 1000
    assert size["file_bytes_a_plan"] > size["data_bytes_a_plan"] > 0
    assert min(size[f"{how}_per_second"] for how in ("bulk", "single", "several", "pages_synced")) > 0
    assert result["yardsticks"]["raw_bytes_a_plan"] == pytest.approx(56 * size["waypoints_a_plan"])
    rows = rows_of(result)
    assert [row["plans"] for row in rows] == ["200", "raw, 200", "greedy split, 200"]


def test_smooth_plans_share_segments_in_a_given_store(folder: Path) -> None:
    url = f"sqlite://{folder}/own.db"
    options = plans.PlanStoreOptions(200, folder, url, smooth=True, rest=0.01, warm=3)
    with Progress(disable=True) as progress:
        result = plans.measure(options, progress)
        [size] = result["sizes"]
        assert size["kept_once"] > 1.2
        assert size["rested_lookup_ms"]["p99"] > 0
        assert "/" in rows_of(result)[0]["after a rest p50 / p99"]
        with pytest.raises(Conflict, match="has plans"):
            plans.measure(options, progress)
    store = open_store(url)
    assert store.plan_statistics().plans == 200
    store.close()
