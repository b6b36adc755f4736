"""Passwords of stores come from files or the environment; in arguments they work, with a warning.

The kind is "a secret that other users of the host can read". Its members: arguments of the cloud, of ``ppaas store``
and of Docker (compose file), the environment of children, a file that others may read.
"""

import stat
from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from storage.urls.opening import open_store
from storage.urls.passwords import MAX_SECRET, chosen_url, read_secret, with_password

SECRET = "p@ss:w/rd %"
QUOTED = "p%40ss%3Aw%2Frd%20%25"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    made = tmp_path / "secret"
    made.touch(mode=0o600)
    made.write_text(f"{SECRET}\n")
    return made


def test_a_password_file_in_the_url_is_read(file: Path) -> None:
    url = f"cassandra://ann@a,b:9142/fleet?timeout=2&password_file={file}"
    assert with_password(url) == f"cassandra://ann:{QUOTED}@a,b:9142/fleet?timeout=2"


@pytest.mark.parametrize(
    "url", ["sqlite:///a/b", "cassandra://ann:p@db/fleet?timeout=2", "cassandra://[", "hdfs://h/p"]
)
def test_other_urls_are_unchanged(url: str) -> None:
    assert with_password(url) == url


@pytest.mark.parametrize(
    ("url", "reason"),
    [
        ("cassandra://db/fleet?password_file={file}", "needs a user without a password"),
        ("cassandra://ann:known@db/fleet?password_file={file}", "needs a user without a password"),
        ("cassandra://ann@db/fleet?password_file={file}&password_file={file}", "needs a user without a password"),
        ("hdfs://h/path?password_file={file}", "hdfs: stores take no password"),
        ("cassandra://ann@db/fleet?password_file={file}x", "cannot read"),
    ],
)
def test_a_password_file_that_cannot_be_used_is_refused_without_a_secret(url: str, reason: str, file: Path) -> None:
    with pytest.raises(InvalidInput, match=reason) as refused:
        open_store(url.format(file=file))
    assert "known" not in str(refused.value)
    assert SECRET not in str(refused.value)


@pytest.mark.parametrize("content", [b"", b" \n", b"\xff", b"x" * (MAX_SECRET + 1)])
def test_a_file_without_a_secret_is_refused(content: bytes, file: Path) -> None:
    file.write_bytes(content)
    with pytest.raises(InvalidInput, match="secret"):
        read_secret(file)


def test_a_file_that_others_may_read_is_a_warning(file: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert read_secret(file) == SECRET
    assert not caplog.records
    file.chmod(stat.S_IRUSR | stat.S_IROTH)
    assert read_secret(file) == SECRET
    assert f"run 'chmod go= {file}'" in caplog.text


def test_a_url_is_taken_from_the_argument_the_file_and_the_environment(file: Path) -> None:
    file.write_text("cassandra://ann:secret@file/fleet\n")
    environment = {"PPAAS_STORE": "cassandra://ann:secret@variable/fleet", "HOME": "/"}

    def choose(url: str | None, of: Path | None) -> str | None:
        return chosen_url("--store", url, of, "PPAAS_STORE", dict(environment))

    assert choose("memory:", None) == "memory:"
    assert choose(None, file) == "cassandra://ann:secret@file/fleet"
    assert choose(None, None) == "cassandra://ann:secret@variable/fleet"
    environment["PPAAS_STORE"] = ""
    assert choose(None, None) is None
    with pytest.raises(InvalidInput, match="either --store or --store-file"):
        choose("memory:", file)


def test_child_processes_do_not_inherit_the_variable() -> None:
    environment = {"PPAAS_STORE": "cassandra://ann:secret@db/fleet"}
    chosen_url("--store", None, None, "PPAAS_STORE", environment)
    assert environment == {}


def test_a_password_in_an_argument_is_a_warning_that_does_not_repeat_it(caplog: pytest.LogCaptureFixture) -> None:
    chosen_url("--store", "cassandra://ann:secret@db/fleet", None, "PPAAS_STORE", {})
    assert "the password in --store is visible to every user of this computer: use --store-file FILE" in caplog.text
    assert "secret" not in caplog.text


@pytest.mark.parametrize("url", ["cassandra://ann@db/fleet", "cassandra://[", "sqlite:file"])
def test_an_argument_without_a_password_is_no_warning(url: str, caplog: pytest.LogCaptureFixture) -> None:
    chosen_url("--store", url, None, "PPAAS_STORE", {})
    assert not caplog.records
