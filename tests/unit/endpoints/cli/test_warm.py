"""``ppaas warm``: exit status and error messages."""

import json
import sys
from pathlib import Path

import pytest

from engine.runtimes.compilation import cache_folder, kernel_wheel, rest_compiler
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


def test_a_wheel_is_put_into_the_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(kernel_wheel, "build_wheel", lambda folder: folder / "kernels.whl")
    assert main(["warm", "--wheel", str(tmp_path)]) == 0
    assert f"{tmp_path / 'kernels.whl'}: install it" in capfd.readouterr().out


def test_the_result_is_printed_as_json_beside_the_progress(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(rest_compiler, "COMMAND", (sys.executable, "-c", "print('half of the kernels')"))
    monkeypatch.setattr(kernel_wheel, "build_wheel", lambda folder: folder / "kernels.whl")
    assert main(["warm", "--wheel", str(tmp_path), "--json"]) == 0
    printed = capfd.readouterr()
    assert printed.err == "half of the kernels\n"
    result = json.loads(printed.out)
    assert result["seconds"] >= 0.0 and result["wheel"] == str(tmp_path / "kernels.whl")


def test_a_wheel_without_compiled_kernels_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As on a computer whose kernels come from a wheel."""
    monkeypatch.setattr(rest_compiler, "COMMAND", (sys.executable, "-c", ""))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert main(["warm", "--wheel", str(tmp_path)]) == 1
    assert "no kernels are compiled here" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.whl"))
