"""``ppaas bench fig3``: errors."""

import pytest

from robots.cli.main import main


@pytest.mark.parametrize(
    ("arguments", "slug"),
    [
        (["fig3", "--map", "none.yaml"], "invalid-map"),
    ],
)
def test_a_missing_map_is_refused(capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")
