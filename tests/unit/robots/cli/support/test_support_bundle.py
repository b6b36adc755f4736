"""``ppaas support-bundle`` against a cloud, with secrets planted wherever it reads."""

import json
import tarfile
from pathlib import Path
from typing import Any

import pytest

from ppaas import __version__
from robots.cli.main import main
from robots.cli.support.support_bundle import LOG_LINES, known_secrets
from tests.support.cloud.command_line import CommandLine
from tests.support.storage.records import house, put_map, robot

SECRET = "h0rse-Battery_9"


def read(path: Path) -> dict[str, str]:
    """Return the texts of a bundle by the names of its files."""
    with tarfile.open(path) as archive:
        members = {member.name: archive.extractfile(member) for member in archive.getmembers()}
        return {name.removeprefix("ppaas-support/"): file.read().decode() for name, file in members.items() if file}


def value(path: Path, name: str) -> Any:
    """Return a value of a bundle."""
    return json.loads(read(path)[f"{name}.json"])


@pytest.fixture
def bundle(tmp_path: Path) -> Path:
    """Return the file of the bundle."""
    return tmp_path / "bundle.tar.gz"


async def test_a_bundle_has_what_the_cloud_and_this_computer_report(
    ppaas: CommandLine, bundle: Path, tmp_path: Path
) -> None:
    data = tmp_path / "var"
    (data / "maps").mkdir(parents=True)
    (data / "maps" / "one").write_bytes(bytes(100))
    (data / "maps" / "two").write_bytes(bytes(23))
    (data / "admin-password").write_text(SECRET)
    ended = await ppaas("support-bundle", str(bundle), "--data", str(data), user="admin")
    assert (ended.status, ended.err) == (0, "")
    assert value(bundle, "versions")["ppaas"] == __version__
    assert value(bundle, "versions")["packages"]["numpy"]
    assert value(bundle, "host")["cpus"] >= 1
    assert value(bundle, "health")["status"]
    assert value(bundle, "doctor")["cloud"] == ppaas.url
    assert value(bundle, "options")["url"] == ppaas.url
    assert all(isinstance(value(bundle, name), list) for name in ("machines", "endpoints", "containers"))
    assert value(bundle, "sizes") == {
        "admin-password": {"files": 1, "bytes": len(SECRET)},
        "maps": {"files": 2, "bytes": 123},
    }
    assert SECRET not in "".join(read(bundle).values())


async def test_no_planted_secret_leaves_the_computer(
    ppaas: CommandLine, bundle: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put_map(ppaas.services.map_store, house("house", owner="admin"))
    ppaas.services.store.put_robot(robot("tb1", user="admin"))
    monkeypatch.setenv("PPAAS_STORE", f"cassandra://ppaas:{SECRET}@db/keyspace")
    monkeypatch.setenv("S3_SECRET_KEY", "of-the-bucket")
    log = tmp_path / "cloud.log"
    token = ppaas.tokens["admin"]
    log.write_text(f"refused: {SECRET}\n{token} is unknown\n?token=of-someone-else&x=1\nof-the-bucket\n")
    ended = await ppaas("support-bundle", str(bundle), "--log", str(log), "--json", user="admin")
    assert ended.status == 0
    found = "".join(read(bundle).values())
    assert not [each for each in (SECRET, token, "of-someone-else", "of-the-bucket") if each in found]
    assert value(bundle, "options")["PPAAS_STORE"] == "cassandra://[removed]@db/keyspace"
    assert json.loads(ended.out) == {"file": str(bundle), "members": sorted(read(bundle))}


async def test_what_a_user_may_not_read_is_named_with_the_reason(ppaas: CommandLine, bundle: Path) -> None:
    assert (await ppaas("support-bundle", str(bundle))).status == 0
    assert value(bundle, "machines")["problem"].startswith("not-permitted: ")


def test_a_cloud_that_is_away_is_in_the_bundle(bundle: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["support-bundle", str(bundle), "--url", "http://127.0.0.1:1"]) == 0
    assert "problem" in value(bundle, "health")
    assert value(bundle, "doctor")["level"] == "error"
    assert str(bundle) in capsys.readouterr().out


def test_the_last_lines_of_a_log_are_taken_and_bytes_that_are_no_text_replaced(bundle: Path, tmp_path: Path) -> None:
    log = tmp_path / "cloud.log"
    log.write_bytes(b"".join(b"line %d \xff\n" % number for number in range(LOG_LINES + 10)))
    assert main(["support-bundle", str(bundle), "--url", "http://127.0.0.1:1", "--log", str(log)]) == 0
    lines = read(bundle)["logs/1-cloud.log"].splitlines()
    assert (len(lines), lines[0]) == (LOG_LINES, "line 10 \N{REPLACEMENT CHARACTER}")


@pytest.mark.parametrize("arguments", [["{0}/none/b.tar.gz"], ["{0}/b.tar.gz", "--log", "{0}/none.log"]])
def test_a_file_that_cannot_be_used_is_refused(
    arguments: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["support-bundle", *(each.format(tmp_path) for each in arguments)]) == 1
    assert "none" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_data_folder_that_is_not_there_is_named(bundle: Path, tmp_path: Path) -> None:
    options = ["--url", "http://127.0.0.1:1", "--data", str(tmp_path / "none")]
    assert main(["support-bundle", str(bundle), *options]) == 0
    assert "there is no folder" in value(bundle, "sizes")["problem"]


def test_the_password_of_a_url_is_known_as_it_is_written_and_as_it_is_meant() -> None:
    environment = {"PPAAS_STORE": "x://u:a%40b@h", "PPAAS_URL": "http://[", "PPAAS_TOKEN": "t1", "OTHER": "x://u:o@h"}
    assert known_secrets(environment, "t2") - {""} == {"a%40b", "a@b", "t1", "t2"}
