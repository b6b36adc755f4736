import io
from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from robots.cli.password import read_password


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_password_file_is_read_without_its_newline(tmp_path: Path) -> None:
    (tmp_path / "password").write_text("correct horse\n")
    assert read_password("ann", tmp_path / "password") == "correct horse"
    (tmp_path / "password").write_bytes(b"\xef\xbb\xbfcorrect horse\r\n")
    assert read_password("ann", tmp_path / "password") == "correct horse"


def test_a_pipe_is_read_up_to_its_first_newline(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(" correct horse \r\nmore\n"))
    assert read_password("ann", None) == " correct horse "


def test_a_terminal_is_prompted_without_an_echo(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def getpass(prompt: str, _stream: object) -> str:
        asked.append(prompt)
        return "correct horse"

    monkeypatch.setattr("sys.stdin", Terminal())
    monkeypatch.setattr("getpass.getpass", getpass)
    assert read_password("ann", None) == "correct horse"
    assert asked == ["password of ann: "]


@pytest.mark.parametrize("content", [None, b"", b"\n", b"\xff\xfe"])
def test_a_file_without_a_password_is_refused(tmp_path: Path, content: bytes | None) -> None:
    if content is not None:
        (tmp_path / "password").write_bytes(content)
    with pytest.raises(InvalidInput, match="password"):
        read_password("ann", tmp_path / "password")


def test_an_empty_pipe_error_names_the_password_file_option(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO())
    with pytest.raises(InvalidInput, match="--password-file"):
        read_password("ann", None)
