"""``ppaas config reload``: signals the cloud process of a data folder, and prints its report."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from endpoints.cli import reload
from engine.processes.exclusive_owner import LOCK
from robots.cli.main import main

OWNER = """
import os, signal, sys
from pathlib import Path
import msgspec
from endpoints.settings.reload import REPORT, ReloadReport
from engine.processes.exclusive_owner import LOCK, sole_owner
from ppaas.clock import uptime

data, problem = Path(sys.argv[1]), sys.argv[2]
changed = [] if len(sys.argv) < 4 else msgspec.json.decode(sys.argv[3], type=list)
def report(**fields):
    fields = {"pid": os.getpid(), "began": uptime(), "file": "/etc/ppaas/ppaas.toml"} | fields
    (data / "partial").write_bytes(msgspec.json.encode(fields))
    (data / "partial").rename(data / REPORT)
signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGHUP])
with sole_owner(data / LOCK, "the folder", "take another"):
    if problem != "is old":
        report()
    print("owns", flush=True)
    while signal.sigwait([signal.SIGHUP]):
        if problem != "is silent":
            report(problem=problem, changed=changed)
"""

Owner = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def data(tmp_path: Path) -> Path:
    (tmp_path / "var").mkdir()
    return tmp_path / "var"


@pytest.fixture
def owner(data: Path) -> Iterator[Owner]:
    """Return a function that starts a process which owns the data folder."""
    processes = []

    def started(*words: str) -> "subprocess.Popen[str]":
        command = [sys.executable, "-c", OWNER, str(data), *words]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        processes.append(process)
        assert process.stdout is not None and process.stdout.readline() == "owns\n"
        return process

    yield started
    for process in processes:
        process.kill()
        process.wait()
        assert process.stdout is not None
        process.stdout.close()


def test_what_was_applied_and_what_needs_a_restart_is_printed(
    data: Path, owner: Owner, capsys: pytest.CaptureFixture[str]
) -> None:
    changed = [
        {"key": "up.idle", "before": "600.0", "after": "7.0", "applied": True},
        {"key": "up.port", "before": "8500", "after": "8600", "applied": False},
    ]
    owner("", json.dumps(changed))
    assert main(["config", "reload", "--data", str(data)]) == 0
    assert capsys.readouterr().out == "up.idle: 600.0 -> 7.0 (applied)\nup.port: 8500 -> 8600 (needs a restart)\n"
    assert main(["config", "reload", "--data", str(data), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"file": "/etc/ppaas/ppaas.toml", "changed": changed}


def test_a_reload_without_a_change(data: Path, owner: Owner, capsys: pytest.CaptureFixture[str]) -> None:
    owner("")
    assert main(["config", "reload", "--data", str(data)]) == 0
    assert capsys.readouterr().out == "nothing has changed in /etc/ppaas/ppaas.toml\n"


def test_a_refusal_is_an_error(data: Path, owner: Owner, capsys: pytest.CaptureFixture[str]) -> None:
    owner("ppaas.toml:2: up.idel is unknown: did you mean idle?")
    assert main(["config", "reload", "--data", str(data)]) == 1
    assert "the settings stay as they are: ppaas.toml:2: up.idel" in capsys.readouterr().err


def test_no_process_is_signalled_that_takes_no_reloads(
    data: Path, owner: Owner, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["config", "reload", "--data", str(data)]) == 1
    assert "no cloud process of this host uses" in capsys.readouterr().err
    process = owner("is old")
    (data / "reload.json").write_text(json.dumps({"pid": process.pid + 1, "began": 0.0}))
    assert main(["config", "reload", "--data", str(data)]) == 1
    assert "takes no reloads" in capsys.readouterr().err and (data / LOCK).exists()
    assert process.poll() is None


def test_a_process_that_does_not_report_is_named(
    data: Path, owner: Owner, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reload, "TIMEOUT", 0.2)
    process = owner("is silent")
    assert main(["config", "reload", "--data", str(data)]) == 1
    assert f"process {process.pid} of host" in capsys.readouterr().err
