"""Errors of ``ppaas machine join`` and ``ppaas machine ticket``; end-to-end tests show that they work."""

import json
import time
from pathlib import Path

import pytest

from engine.remote.authority import Authority
from engine.remote.joining import Ticket, read_ticket
from engine.remote.machines import ADDRESS
from engine.remote.replica import MACHINES
from robots.cli.main import main

TICKET = str(Ticket("127.0.0.1", 1, "ab" * 32, "secret"))


def refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Return the error of a command that exits with status 1."""
    assert main(["machine", *arguments]) == 1
    return capsys.readouterr().err


def test_a_machine_that_has_not_joined_needs_a_ticket(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "join with a ticket" in refused(["join", "--data", str(tmp_path / "m")], capsys)


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        (["rubbish"], "not a ticket"),
        ([TICKET, "--name", "a/b"], "not a valid name"),
        ([TICKET, "--name", "m2"], "no answer at tls://127.0.0.1:1"),
        ([TICKET, "--endpoints", "2", "--port", "0"], "--port other than 0"),
        ([TICKET, "--endpoints", "2", "--tls-cert", "a.pem"], "--tls-key"),
        (["--join-secret-file", "none"], "needs --master"),
        (["--join-secret-file", "none", "--master", "127.0.0.1:1"], "join secrets in none cannot be read"),
        (["--join-secret-file", "none", "--master", "127.0.0.1:1", "--name", "a/b"], "not a valid name"),
    ],
)
def test_a_failed_join_reports_the_reason_and_stores_nothing(
    arguments: list[str], error: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert error in refused(["join", *arguments, "--data", str(tmp_path / "m")], capsys)
    assert not (tmp_path / "m").exists()


def test_join_reports_an_unreadable_membership_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "membership.json").write_text("{")
    assert "join with a new ticket" in refused(["join", "--data", str(tmp_path)], capsys)


@pytest.mark.parametrize(
    "arguments",
    [
        ["--cores", "0"],
        ["--cores", "x"],
        ["--label", "zone"],
        ["--label", "=x"],
        ["--endpoints", "-1"],
        ["--endpoints", "1", "--advertise", "hall-2:8500"],
        ["--endpoints", "1", "--advertise", "ftp://hall-2"],
        ["--endpoints", "1", "--dead", "0.5"],
        ["--master", "nowhere"],
    ],
)
def test_invalid_arguments_of_join_are_refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["machine", "join", TICKET, *arguments])
    assert "usage:" in capsys.readouterr().err


def test_ticket_requires_a_cloud_that_listens_for_machines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "--listen-machines" in refused(["ticket", "--data", str(tmp_path)], capsys)


@pytest.mark.parametrize("seconds", ["0", "-1", "nan", "inf", "1e9", "soon"])
def test_an_invalid_ticket_lifetime_is_refused(seconds: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["machine", "ticket", "--valid", seconds])
    assert "--valid" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        (["--listen-machines", "nowhere"], "host:port"),
        (["--listen-machines", "127.0.0.1:70000"], "from 0 to 65535"),
        (["--listen-machines", "127.0.0.1:0", "--store", "memory:"], "cassandra:"),
        (["--listen-machines", "192.0.2.1:0"], "listen"),
    ],
)
def test_up_exits_if_machines_could_not_connect(
    arguments: list[str], error: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["up", "--port", "0", "--data", str(tmp_path), *arguments]) == 1
    assert error in capsys.readouterr().err


def test_a_ticket_is_printed_as_json_with_its_expiry(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / MACHINES
    Authority(folder)
    (folder / ADDRESS).write_text("tls://127.0.0.1:8501")
    before = time.time()
    assert main(["machine", "ticket", "--data", str(tmp_path), "--valid", "60", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert read_ticket(printed["ticket"]).port == 8501
    assert before + 60.0 <= printed["expires"] <= time.time() + 60.0
