"""``ppaas machine hand-over``: signals the cloud process of a data folder, and waits for its end."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from endpoints.audit.file_log import AUDIT
from endpoints.cli import machine_hand_over
from engine.processes.exclusive_owner import LOCK
from robots.cli.main import main

OWNER = """
import signal, sys
from pathlib import Path
from engine.processes.exclusive_owner import sole_owner

signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGUSR1])
with sole_owner(Path(sys.argv[1]), "the folder", "take another"):
    print("owns", flush=True)
    while signal.sigwait([signal.SIGUSR1]) and sys.argv[2] == "stays":
        pass
"""


@pytest.fixture
def data(tmp_path: Path) -> Path:
    (tmp_path / "var").mkdir()
    return tmp_path / "var"


def owner(data: Path, how: str) -> "subprocess.Popen[str]":
    command = [sys.executable, "-c", OWNER, str(data / LOCK), how]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "owns\n"
    return process


def test_the_process_is_asked_and_its_end_is_awaited(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    process = owner(data, "ends")
    assert main(["machine", "hand-over", "--data", str(data), "--json"]) == 0
    assert process.wait(20.0) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["pid"] == process.pid and printed["seconds"] >= 0.0
    assert '"hand_over"' in (data / AUDIT).read_text()


def test_a_process_that_does_not_end_is_named(
    data: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(machine_hand_over, "TIMEOUT", 0.2)
    process = owner(data, "stays")
    try:
        assert main(["machine", "hand-over", "--data", str(data)]) != 0
        assert f"process {process.pid} of host" in (told := capsys.readouterr().err) and "it does not lead" in told
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize("left", [False, True], ids=["new folder", "killed process"])
def test_without_a_process_it_is_refused(data: Path, left: bool, capsys: pytest.CaptureFixture[str]) -> None:
    if left:
        process = owner(data, "stays")
        process.kill()
        process.wait()
    assert main(["machine", "hand-over", "--data", str(data)]) != 0
    assert "no cloud process of this host uses" in capsys.readouterr().err
