"""``ppaas bench scaling``: JSON, table, and errors."""

from pathlib import Path

import pytest

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
