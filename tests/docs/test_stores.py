"""Commands of stores.md work, and its stores are those of the code."""

import os
import re
import subprocess
import sys
from pathlib import Path

from endpoints import store_options
from endpoints.accounts.tokens import TokenCache
from endpoints.cli import store as command
from endpoints.resources.services import MapHeadCache
from robots.cli.command_parser import CommandParser
from storage.cassandra.connection.address import CONSISTENCIES, PORT, SETTINGS, parse_address
from storage.cassandra.plans.entries import GRACE
from storage.cassandra.plans.passage_index import PLANS_PER_CELL
from storage.store_and_forward.plan_outbox import MAX_BYTES
from storage.urls.opening import open_map_store, open_store
from storage.urls.passwords import with_password
from storage.urls.registry import MAP_STORES, STORES
from tests.support.documents import script, table, text_of
from tests.support.storage.full_store import fill, fill_maps

PAGE = "docs/stores.md"


def test_the_stores_are_those_of_the_code() -> None:
    rows = table(PAGE, "ppaas up", "URL", "backend")
    for option, backends in (("--store", STORES), ("--map-store", MAP_STORES)):
        found = {
            url.partition(":")[0]: re.search(r"\.\[(\w+)\]", backend)
            for listed, url, backend in rows
            if listed == option
        }
        assert {name: extra and extra[1] for name, extra in found.items()} == {
            name: backends.load(name).extra for name in backends.names()
        }


def test_the_commands_move_both_stores(tmp_path: Path) -> None:
    assert "ppaas.sqlite" in Path(store_options.__file__).read_text(encoding="utf-8")
    store = open_store(f"sqlite://{tmp_path / 'var' / 'ppaas.sqlite'}")
    fill(store, plans=5, robots=3)
    store.close()
    fill_maps(open_map_store(f"file://{tmp_path / 'var' / 'maps'}"))
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    typed = ["bash", "-c", "set -euo pipefail\n" + script(PAGE)]
    ended = subprocess.run(typed, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert '"copied": 0' in ended.stdout and "differs" not in ended.stdout
    assert [head.id for head in open_map_store(f"file://{tmp_path / 'moved' / 'maps'}").maps()] == ["alone", "house"]


def test_the_options_are_those_of_the_code() -> None:
    named = set(re.findall(r"--\w[\w-]*", text_of(PAGE)))
    assert named == {
        "--store", "--map-store", "--json", "--overwrite", "--ready-file", "--linger",
        "--store-file", "--map-store-file", "--allow",
    }  # fmt: skip


AWAY_PAGE = text_of("docs/stores.md")


def test_the_url_shows_all_settings(tmp_path: Path) -> None:
    [url] = re.findall(r"^cassandra://\S+$", AWAY_PAGE, re.MULTILINE)
    secret = tmp_path / "db"
    secret.write_text("password\n")
    address = parse_address(with_password(url.replace("/run/secrets/db", str(secret))))
    assert (address.user, address.password, address.hosts) == ("user", "password", ("host1", "host2"))
    assert all(f"{name}=" in url for name in SETTINGS)
    assert all(f"`{name}`" in AWAY_PAGE for name in CONSISTENCIES)
    assert f"{PORT} by default" in AWAY_PAGE


def test_the_numbers_are_those_of_the_code() -> None:
    assert f"written for {GRACE / 3600:g} h" in AWAY_PAGE
    assert f"{MAX_BYTES >> 20} MiB" in AWAY_PAGE
    for kept in (TokenCache(), MapHeadCache()):
        assert f"within {kept._patience / 3600:g} h" in AWAY_PAGE
    decision = " ".join(text_of("docs/adr/0020-cassandra-without-transactions.md").split())
    assert f"at most {PLANS_PER_CELL} plans" in decision
    assert f"not written for {GRACE / 2 / 3600:g} h writes it again" in decision


def test_the_sweep_command_exists() -> None:
    parser = CommandParser()
    command.configure(parser)
    assert "`ppaas store sweep URL`" in AWAY_PAGE
    assert parser.parse_args(["sweep", "cassandra://db/ppaas"]).store == "cassandra://db/ppaas"
