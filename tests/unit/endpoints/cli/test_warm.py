"""``ppaas warm``: exit status and error messages."""

import sys

import pytest

from engine.runtimes.compilation import cache_folder, rest_compiler
from robots.cli.main import main


def test_compiled_kernels_are_left_as_they_are(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["warm"]) == 0
    assert "all kernels are compiled, after " in capfd.readouterr().out


def test_a_kernel_that_cannot_be_compiled_is_the_exit_status(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(rest_compiler, "COMMAND", (sys.executable, "-c", "import sys; sys.exit('no compiler')"))
    assert main(["warm"]) == 1
    assert capfd.readouterr() == ("", "no compiler\n")


def test_a_cache_that_cannot_be_written_is_reported(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cache_folder, "is_writable", lambda: False)
    assert main(["warm"]) == 1
    assert "set NUMBA_CACHE_DIR" in capsys.readouterr().err
