"""``ppaas store``."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace

import pytest

from robots.cli import main
from storage.urls import opening
from storage.urls.opening import open_map_store, open_store
from tests.support.storage.full_store import KINDS, fill, fill_maps
from tests.support.storage.records import robot, user


@pytest.fixture
def stores(tmp_path: Path) -> tuple[str, str]:
    """Return the URLs of a full store and of a missing one."""
    url = f"sqlite://{tmp_path / 'from.db'}"
    store = open_store(url)
    fill(store, plans=5, robots=3)
    store.close()
    return url, f"sqlite://{tmp_path / 'to.db'}"


def test_store_migrate_copies_compares_and_reports_all_records(
    stores: tuple[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["store", "migrate", *stores]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert lines[0] == ["kind", "records", "copied", "same", "different", "missing", "beyond", "digest"]
    assert [line[0] for line in lines[1:]] == list(KINDS)
    assert lines[3][:7] == ["robots", "5", "5", "5", "0", "0", "0"]
    assert main.main(["store", "migrate", *stores, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["good"]
    assert {kind["kind"]: kind["copied"] for kind in report["kinds"]} == dict.fromkeys(KINDS, 0)
    assert all(kind["digest"] == kind["digest_there"] for kind in report["kinds"])


def test_store_check_names_differences_and_exits_with_status_1(
    stores: tuple[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    open_store(stores[1]).close()
    assert main.main(["store", "check", *stores, "--json"]) == 1
    assert not json.loads(capsys.readouterr().out)["good"]
    main.main(["store", "migrate", *stores])
    target = open_store(stores[1])
    target.put_robot(robot("tb2", cores=3.0))
    target.close()
    assert main.main(["store", "check", *stores]) == 1
    assert capsys.readouterr().out.endswith("differs or is missing: robots ann/tb2\n")
    assert main.main(["store", "migrate", *stores]) == 1
    assert main.main(["store", "migrate", *stores, "--overwrite"]) == 0


@pytest.mark.parametrize("as_json", [[], ["--json"]], ids=["table", "JSON"])
@pytest.mark.parametrize("content", ["nothing", "a user", "a user and a robot"])
def test_store_migrate_copies_a_store_without_records_of_most_kinds(
    tmp_path: Path, content: str, as_json: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    urls = [f"sqlite://{tmp_path / name}" for name in ("from.db", "to.db")]
    source = open_store(urls[0])
    if content != "nothing":
        source.add_user(user("ann"))
    if content == "a user and a robot":
        source.put_robot(robot("tb1"))
    source.close()
    for verb in ("migrate", "migrate", "check"):
        assert main.main(["store", verb, *urls, *as_json]) == 0
    assert "robots" in capsys.readouterr().out
    target = open_store(urls[1])
    assert [one.id for one in target.users()] == (["ann"] if content != "nothing" else [])
    target.close()


def test_store_migrate_copies_an_empty_map_store(tmp_path: Path) -> None:
    urls = [f"file://{tmp_path / name}" for name in ("from", "to")]
    open_map_store(urls[0])
    for verb in ("migrate", "check"):
        assert main.main(["store", verb, *urls]) == 0


@pytest.mark.parametrize("kind", ["sqlite", "file"])
def test_nothing_is_created_but_the_target_of_a_migration(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    there, missing = (f"{kind}://{tmp_path / name}" for name in ("there", "missing"))
    opened = open_store(there) if kind == "sqlite" else open_map_store(there)
    if kind == "sqlite":
        opened.close()  # type: ignore[union-attr]
    before = sorted(tmp_path.iterdir())
    for command in (["check", there, missing], ["check", missing, there], ["migrate", missing, there]):
        assert main.main(["store", *command]) == 1
        assert f"unknown store '{missing}'" in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before
    assert main.main(["store", "sweep", f"sqlite://{tmp_path / 'missing'}"]) == 1
    assert sorted(tmp_path.iterdir()) == before
    assert main.main(["store", "migrate", there, missing]) == 0


@pytest.mark.parametrize("command", [["check", "{at}"], ["migrate", "{at}", "{to}"], ["check", "{there}", "{at}"]])
@pytest.mark.parametrize("kind", ["sqlite", "file"])
def test_an_empty_file_or_a_folder_of_something_else_is_no_store(
    kind: str, command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A power loss may leave an empty file, and a folder is easily mistyped: neither is a store without faults."""
    names = {name: f"{kind}://{tmp_path / name}" for name in ("at", "to", "there")}
    if kind == "sqlite":
        (tmp_path / "at").touch()
        open_store(names["there"]).close()  # type: ignore[attr-defined]
    else:
        (tmp_path / "at").mkdir()
        (tmp_path / "at" / "letter").write_text("of something else")
        open_map_store(names["there"])
    assert main.main(["store", *(word.format(**names) for word in command)]) == 1
    assert f"unknown store '{names['at']}'; the f" in capsys.readouterr().err
    assert not (tmp_path / "to").exists()
    at = tmp_path / "at"
    assert [path.name for path in at.iterdir()] == ["letter"] if at.is_dir() else at.read_bytes() == b""


@pytest.mark.parametrize("other", ["x/../there", "there/inner", "./there"])
@pytest.mark.parametrize("kind", ["sqlite", "file"])
def test_a_store_is_not_copied_into_itself(
    kind: str, other: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    there, again = f"{kind}://{tmp_path}/there", f"{kind}://{tmp_path}/{other}"
    opened = open_store(there) if kind == "sqlite" else open_map_store(there)
    if kind == "sqlite":
        opened.close()  # type: ignore[union-attr]
    for urls in ((there, again), (again, there)):
        assert main.main(["store", "migrate", *urls]) == 1
        assert "FROM and TO are the same store" in capsys.readouterr().err


def test_store_migrate_copies_map_stores(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    urls = [f"file://{tmp_path / name}" for name in ("from", "to")]
    fill_maps(open_map_store(urls[0]))
    assert main.main(["store", "migrate", *urls]) == 0
    assert capsys.readouterr().out.splitlines()[1].split()[:7] == ["maps", "2", "2", "2", "0", "0", "0"]
    assert [head.id for head in open_map_store(urls[1]).maps()] == ["alone", "house"]


@pytest.mark.parametrize(
    ("source", "target", "error"),
    [
        ("sqlite:///nowhere/at/all.db", "memory:", "not-found: unknown store 'sqlite:///nowhere/at/all.db'"),
        ("file:///nowhere/at/all", "file:///tmp/maps", "not-found: unknown store 'file:///nowhere/at/all'"),
        ("memory:", "memory:", "invalid-input: FROM and TO are the same store"),
        ("sqlite:///a.db", "file:///b", "do not store the same kind of data"),
        ("mysql://a", "sqlite:///b.db", "do not store the same kind of data"),
        ("sqlite://host/a.db", "memory:", "has no path"),
    ],
)
def test_store_migrate_reports_why_it_cannot_migrate(
    source: str, target: str, error: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["store", "migrate", source, target]) == 1
    assert error in capsys.readouterr().err


def test_store_check_of_one_store_names_what_is_damaged(
    stores: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["store", "check", stores[0]]) == 0
    assert "0 damaged" in capsys.readouterr().out
    with closing(sqlite3.connect(tmp_path / "from.db", isolation_level=None)) as connection:
        connection.execute("UPDATE users SET record = x'00' WHERE id = 'ann'")
    assert main.main(["store", "check", stores[0]]) == 1
    assert "users/ann is damaged" in capsys.readouterr().out
    assert main.main(["store", "check", stores[0], "--json"]) == 1
    report = json.loads(capsys.readouterr().out)
    assert not report["good"]
    assert [len(kind["damaged"]) for kind in report["kinds"] if kind["kind"] == "users"] == [1]
    assert main.main(["store", "check", stores[1]]) == 1
    assert "unknown store" in capsys.readouterr().err
    maps = f"file://{tmp_path / 'maps'}"
    fill_maps(open_map_store(maps))
    assert main.main(["store", "check", maps]) == 0


def test_a_sweep_prints_the_number_of_removed_segments_as_json(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    store = SimpleNamespace(sweep_entries=lambda: 7, close=lambda: None)
    monkeypatch.setattr(opening, "open_existing_store", lambda _url: store)
    assert main.main(["store", "sweep", "cassandra://127.0.0.1/ppaas", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"removed": 7}
