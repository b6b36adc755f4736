"""``ppaas bench service``: options."""

import pytest

from benchmarks.commands.cloud import ServiceBench
from benchmarks.service import suite
from robots.cli.main import main


def test_a_running_cloud_requires_a_token(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.delenv("PPAAS_TOKEN", raising=False)
    assert main(["bench", "service", "--url", "http://127.0.0.1:1"]) == 1
    assert "not-authenticated" in capsys.readouterr().err


def test_an_unknown_part_is_refused_with_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["bench", "service", "--only", "weather"])
    assert "fleet" in capsys.readouterr().err


def test_every_known_part_is_measured() -> None:
    assert set(ServiceBench.PARTS) == {*suite.PARTS, *suite.STARTS}
