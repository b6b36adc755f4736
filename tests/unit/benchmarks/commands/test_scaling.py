"""``ppaas bench scaling``: JSON, table, and errors."""

from pathlib import Path

import pytest

from benchmarks.planners import scaling
from robots.cli.main import main
from tests.unit.benchmarks.commands.conftest import RunBench


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
