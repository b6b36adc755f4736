"""``ppaas bench scaling``: JSON, table, and errors."""

from pathlib import Path

import pytest

from robots.cli.main import main
from tests.unit.benchmarks.commands.conftest import Told


def test_scaling_has_a_number_for_each_size(tmp_path: Path, told: Told) -> None:
    plot = tmp_path / "scaling.png"
    answer = told("scaling", "--kind", "empty", "--largest", "600", "--threads", "1", "--plot", str(plot))
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
def test_what_cannot_be_measured_is_refused(
    capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str
) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")
