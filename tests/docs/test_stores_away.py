"""Cassandra settings and limits for an unreachable store in stores.md are those of the code."""

import re
from pathlib import Path

from endpoints.accounts.tokens import TokenCache
from endpoints.cli import store as command
from endpoints.services.services import MapHeadCache
from robots.cli.command_parser import CommandParser
from storage.cassandra.connection.address import CONSISTENCIES, PORT, SETTINGS, parse_address
from storage.cassandra.plans.entries import GRACE
from storage.cassandra.plans.passage_index import PLANS_PER_CELL
from storage.store_and_forward.plan_outbox import MAX_BYTES
from storage.urls.passwords import with_password
from tests.support.documents import text_of

PAGE = text_of("docs/stores.md")


def test_the_url_shows_all_settings(tmp_path: Path) -> None:
    [url] = re.findall(r"^cassandra://\S+$", PAGE, re.MULTILINE)
    secret = tmp_path / "db"
    secret.write_text("password\n")
    address = parse_address(with_password(url.replace("/run/secrets/db", str(secret))))
    assert (address.user, address.password, address.hosts) == ("user", "password", ("host1", "host2"))
    assert all(f"{name}=" in url for name in SETTINGS)
    assert all(f"`{name}`" in PAGE for name in CONSISTENCIES)
    assert f"{PORT} by default" in PAGE


def test_the_numbers_are_those_of_the_code() -> None:
    assert f"written for {GRACE / 3600:g} h" in PAGE
    assert f"{MAX_BYTES >> 20} MiB" in PAGE
    for kept in (TokenCache(), MapHeadCache()):
        assert f"within {kept._patience / 3600:g} h" in PAGE
    decision = " ".join(text_of("docs/adr/0020-cassandra-without-transactions.md").split())
    assert f"at most {PLANS_PER_CELL} plans" in decision
    assert f"not written for {GRACE / 2 / 3600:g} h writes it again" in decision


def test_the_sweep_command_exists() -> None:
    parser = CommandParser()
    command.configure(parser)
    assert "`ppaas store sweep URL`" in PAGE
    assert parser.parse_args(["sweep", "cassandra://db/ppaas"]).store == "cassandra://db/ppaas"
