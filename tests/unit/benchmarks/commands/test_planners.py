"""Commands of the benches of planners."""

import json
from pathlib import Path

import pytest

from benchmarks.planners import compare, peers, scaling
from robots.cli.main import main
from tests.unit.benchmarks.commands.conftest import RunBench


def test_missing_and_unsuitable_peers_are_reported(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    field, path = peers.FIELDS[2], peers.PATHS[0]
    absent = peers.Peer("f", "absent-peer", "absent_peer", "nothing", field.prepare, field.told)
    small = peers.Peer(field.name, field.package, field.module, field.solves, field.prepare, field.told, 9)
    monkeypatch.setattr(compare, "BESIDE", {"absent-peer": absent, "scipy": small})
    monkeypatch.setattr(compare, "PATHS", ())
    assert main(["bench", "compare", "--empty", "8", "--threads", "1"]) == 0
    out, err = capsys.readouterr()
    assert "absent-peer f is left out: not installed" in err
    assert "scipy csgraph.dijkstra is left out: the grid is too large" in err
    assert "ppaas dijkstra, 1 thread" in out and path.package not in out


@pytest.mark.parametrize(
    ("arguments", "slug"),
    [
        (["compare", "--empty", "3", "--only", "ours"], "not-found"),
    ],
)
def test_an_unknown_peer_is_refused(capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")


@pytest.mark.parametrize(
    ("arguments", "slug"),
    [
        (["fig3", "--map", "none.yaml"], "invalid-map"),
    ],
)
def test_a_missing_map_is_refused(capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")


def test_the_json_contains_the_times_per_number_of_threads(map_: Path, run_bench: RunBench) -> None:
    answer = run_bench("index", "--map", str(map_), "--tiles", "3", "--threads", "1,2")
    assert set(answer) == {
        "grid", "planner", "seconds", "bytes", "queries", "wrong", "mean_us", "p50_us", "p99_us",
        "plans", "map_us", "seen_us", "seen_wrong", "cpus",
    }  # fmt: skip
    assert (answer["grid"], answer["planner"], answer["wrong"]) == ("3 by 3 times a", "hub_labels", 0)
    assert set(answer["seconds"]) == {"1", "2"}


@pytest.mark.parametrize(
    ("arguments", "slug"),
    [
        (["index", "--empty", "9", "--planner", "dijkstra"], "invalid-parameter"),
    ],
)
def test_a_planner_without_an_index_is_refused(
    capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str
) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")


def test_planning_is_measured_without_a_cloud(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "planning", "--quick", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)["figures"]
    assert {figure["name"] for figure in figures} >= {
        "empty 256², layers", "empty 256², dijkstra",
        "pillars 256², exact inflation 0.55 m, threads 1", "depth image 640×480 uint16 → scan, 10 rows",
    }  # fmt: skip
    assert all(figure["value"] > 0.0 for figure in figures)


def test_the_result_has_one_value_per_size(tmp_path: Path, run_bench: RunBench) -> None:
    plot = tmp_path / "scaling.png"
    answer = run_bench("scaling", "--kind", "empty", "--largest", "600", "--threads", "1", "--plot", str(plot))
    assert answer["sizes"] == [256, 512]
    assert len(answer["ns_per_cell"]["empty"]["1"]) == 2
    assert plot.exists()


@pytest.mark.parametrize(
    ("arguments", "slug"),
    [
        (["scaling", "--largest", "255"], "invalid-parameter"),
        (["scaling", "--kind", "forest", "--largest", "256"], "not-found"),
    ],
)
def test_invalid_sizes_and_unknown_kinds_are_refused(
    capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str
) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")


def test_planners_are_measured_beside_dijkstra(run_bench: RunBench) -> None:
    answer = run_bench(
        "scaling", "--kind", "random 10 %", "--largest", "1024", "--planner", "jps", "--planner", "navfn"
    )
    jps = answer["planners"]["random 10 %"]["jps"]
    assert list(answer["planners"]["random 10 %"]) == ["dijkstra", "jps", "navfn"]
    assert [len(jps[key]) for key in ("first", "next", "times")] == [len(answer["sizes"])] * 3 == [3] * 3
    assert (jps["wrong"], jps["exponent"]) == (0, None), "it needs two sizes from 1024 on"


def test_the_exponent_is_the_slope_of_the_logarithms() -> None:
    assert scaling._exponent([512, 1024, 2048, 4096], [9.0, 1.0, 4.0, 16.0]) == pytest.approx(2.0)
    assert scaling._exponent([1024, 2048], [1.0, None]) is None


def test_the_json_contains_statistics_and_index_size(map_: Path, run_bench: RunBench) -> None:
    answer = run_bench("scenario", f"{map_}.scen", "--map", str(map_), "--planner", "dijkstra", "--limit", "1")
    assert set(answer) == {
        "planner", "queries", "wrong", "mean_us", "p50_us", "p99_us", "index_seconds", "index_bytes",
    }  # fmt: skip
    assert (answer["planner"], answer["queries"], answer["wrong"]) == ("dijkstra", 1, 0)


def test_the_map_of_a_scenario_is_found_beside_it(map_: Path, run_bench: RunBench) -> None:
    assert run_bench("scenario", f"{map_}.scen")["wrong"] == 0


def test_the_default_output_is_a_table(capsys: pytest.CaptureFixture[str], map_: Path) -> None:
    assert main(["bench", "scenario", f"{map_}.scen"]) == 0
    heading, row = (line.split("  ") for line in capsys.readouterr().out.splitlines())
    assert (heading[0].strip(), row[0].strip()) == ("planner", "dijkstra")


@pytest.mark.parametrize(
    ("arguments", "slug"),
    [
        (["scenario", "none.scen"], "invalid-map"),
    ],
)
def test_a_missing_scenario_is_refused(capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")
