"""The program of the simulated rover: it refuses what it cannot drive with, in words."""

from pathlib import Path

import pytest

from robots.sim.mavlink.__main__ import arguments_of, main

PLACE = ["--latitude", "47.4", "--longitude", "8.5"]


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ([*PLACE, "--system", "0"], "from 1 to 255, not 0"),
        (["--latitude", "90", "--longitude", "8.5"], "--latitude is between"),
        (["--latitude", "nan", "--longitude", "8.5"], "--latitude is between"),
    ],
)
def test_arguments_beyond_their_limits_are_refused(
    words: list[str], reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        arguments_of(words)
    assert reason in capsys.readouterr().err


def test_a_key_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match=r"cannot read the key of .*missing"):
        main([*PLACE, "--passphrase-file", str(tmp_path / "missing")])
