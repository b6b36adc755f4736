"""``ppaas login`` and ``ppaas user link``: with passwords, and with an identity provider over real sockets."""

import asyncio
import json
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from argon2 import PasswordHasher, profiles

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.app import create_app
from endpoints.oidc.logins import OidcLogins
from endpoints.oidc.settings import OidcSettings
from endpoints.resources.services import Services
from robots.cli.commands import login
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.cloud.command_line import PASSWORD, CommandLine
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.serving import serve
from tests.support.identity.identity_server import AUDIENCE, CLIENT, SECRET, IdentityServer, identity_server
from tests.support.waiting import until


@pytest.fixture
async def idp() -> AsyncIterator[IdentityServer]:
    async with identity_server() as running:
        yield running


@pytest.fixture
async def line(
    idp: IdentityServer, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> AsyncIterator[CommandLine]:
    """Return the command line of a cloud with an identity provider."""
    (tmp_path / "secret").write_text(SECRET)
    store, cloud = MemoryStore(), FakeCloud()
    accounts = Accounts(store, passwords=Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=1))
    settings = OidcSettings(
        issuer=idp.issuer, client_id=CLIENT, cloud_url="http://127.0.0.1", roles=(("staff", "user"),),
        secret_file=str(tmp_path / "secret"), audience=AUDIENCE,
    )  # fmt: skip
    services = Services(store, MemoryMapStore(), accounts, cloud, oidc=OidcLogins(settings))
    async with serve(create_app(services)) as port:
        yield CommandLine(f"http://127.0.0.1:{port}", services, cloud, capsys.readouterr, monkeypatch)
    accounts.close()


async def owner(line: CommandLine, token: str) -> str:
    return (await line.services.accounts.authenticate(token.strip())).id


async def test_a_device_logs_in_once_its_person_has_entered_the_code(
    line: CommandLine, idp: IdentityServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(login, "LEAST_INTERVAL", 0.01)
    working = asyncio.create_task(line("login", "--oidc", user=None))
    await until(lambda: idp.asked.count("token") >= 2)
    assert not working.done()
    idp.devices = dict.fromkeys(idp.devices, True)
    ended = await working
    assert ended.status == 0, ended.err
    assert ended.err == f"open {idp.issuer}/activate and log in; the code is ABCD-EFGH\n"
    assert await owner(line, ended.out) == "ann"


async def test_a_device_whose_person_does_not_come_gets_no_token(
    line: CommandLine, idp: IdentityServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(login, "LEAST_INTERVAL", 0.01)
    idp.expires_in = 0.1
    ended = await line("login", "--oidc", user=None)
    assert (ended.status, ended.out) == (1, "")
    assert "nobody has logged in within 0.1 s" in ended.err


async def test_a_program_exchanges_its_access_token(line: CommandLine, idp: IdentityServer, tmp_path: Path) -> None:
    file = tmp_path / "token"
    file.write_text(idp.token(AUDIENCE) + "\n")
    ended = await line("login", "--access-token-file", str(file), "--json", user=None)
    assert ended.status == 0, ended.err
    assert await owner(line, json.loads(ended.out)["token"]) == "ann"
    piped = await line("login", "--access-token-file", "-", user=None, stdin=idp.token(AUDIENCE))
    assert await owner(line, piped.out) == "ann"
    refused = await line("login", "--access-token-file", "-", user=None, stdin=idp.token("another"))
    assert (refused.status, refused.out) == (1, "") and "not-authenticated" in refused.err


@pytest.mark.parametrize("words", [[], ["ann", "--oidc"], ["ann", "--access-token-file", "x"]])
async def test_one_way_to_log_in_is_given(line: CommandLine, words: list[str]) -> None:
    ended = await line("login", *words, user=None)
    assert ended.status == 1 and "one of them" in ended.err


async def test_an_administrator_links_a_user_by_command(ppaas: CommandLine) -> None:
    command = ["user", "link", "ann", "id-of-ann", "--issuer", "https://login.example"]
    assert (await ppaas(*command, user="bob")).status == 1
    linked = await ppaas(*command, "--json", user="admin")
    assert json.loads(linked.out)["identity"] == {"issuer": "https://login.example", "subject": "id-of-ann"}
    assert (await ppaas("user", "link", "ann", "--off", user="admin")).status == 0
    assert ppaas.services.store.user("ann").identity is None


@pytest.mark.parametrize("words", [[], ["s"], ["--issuer", "u"], ["s", "--issuer", "u", "--off"], ["s", "--off"]])
async def test_a_link_has_a_subject_and_an_issuer_or_is_off(ppaas: CommandLine, words: list[str]) -> None:
    ended = await ppaas("user", "link", "ann", *words, user="admin")
    assert ended.status == 1 and "--off alone" in ended.err


async def test_a_password_logs_in_as_before(ppaas: CommandLine) -> None:
    ended = await ppaas("login", "ann", user=None, stdin=f"{PASSWORD}\n")
    assert await owner(ppaas, ended.out) == "ann"
