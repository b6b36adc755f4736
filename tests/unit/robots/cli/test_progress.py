"""Progress of a request."""

import pytest
from rich.console import Console

from robots.cli.progress import progress_bar


def test_without_a_terminal_nothing_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar("publish office") as report:
        assert report is None
    assert capsys.readouterr().err == ""


def test_a_terminal_shows_what_is_done(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(Console, "is_terminal", True)
    with progress_bar("publish office") as report:
        assert report is not None
        report("draw the map", 0.5)
    assert "publish office: draw the map" in capsys.readouterr().err
