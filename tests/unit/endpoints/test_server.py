"""Start conditions of the server, and its process from start to clean stop."""

import asyncio
import contextlib
import json
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from endpoints.cli import machine_join, up
from endpoints.cloud_processes import serving
from endpoints.cloud_processes.config import front_config
from endpoints.cloud_processes.keeper import COMMAND
from endpoints.cloud_processes.leading import take_the_lead
from endpoints.cloud_processes.server import admin_password, cloud_config
from engine.agent import main as agent_main
from engine.fabric import router
from engine.local.kept_process import SpareProcesses
from engine.remote.authority import STANDBY, Authority
from engine.remote.joining import Ticket
from engine.remote.machines import ADDRESS
from engine.remote.replica import MACHINES
from ppaas.errors import InvalidInput, Unavailable
from ppaas.maps.generate import office
from robots.cli.command_parser import CommandParser
from robots.cli.main import main
from robots.client.rest import RestClient
from storage.urls.opening import open_store
from tests.support.cloud.cloud import publish_map
from tests.support.cloud.up_process import Up
from tests.support.network.ipv6 import needs_ipv6
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose


def test_an_admin_password_is_created_once_with_mode_0600(tmp_path: Path) -> None:
    made = admin_password(tmp_path / "password")
    assert len(made) >= 16
    assert admin_password(tmp_path / "password") == made
    assert stat.S_IMODE((tmp_path / "password").stat().st_mode) == 0o600


def test_an_existing_admin_password_is_read(tmp_path: Path) -> None:
    (tmp_path / "password").write_text("correct horse\n")
    assert admin_password(tmp_path / "password") == "correct horse"


def test_an_empty_password_file_of_a_killed_start_gets_a_password(tmp_path: Path) -> None:
    (tmp_path / "password").touch()
    made = admin_password(tmp_path / "password")
    assert len(made) >= 16
    assert (tmp_path / "password").read_text() == f"{made}\n"


def test_a_password_file_that_others_may_read_is_reported(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "password").write_text("correct horse\n")
    (tmp_path / "password").chmod(0o644)
    admin_password(tmp_path / "password")
    assert "other users of this computer have access" in caplog.text


def test_a_password_file_that_cannot_be_created_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="password file"):
        admin_password(tmp_path / "nowhere" / "password")


@pytest.mark.parametrize(
    ("moment", "number"), [(agent_main.__name__, signal.SIGTERM), (router.__name__, signal.SIGINT)]
)
def test_a_signal_during_start_ends_the_cloud_cleanly(tmp_path: Path, moment: str, number: int) -> None:
    up = Up(tmp_path)
    up.wait_for(lambda: up.children(moment))
    assert up.end(number) == 0
    assert not up.ready.exists()
    assert "Traceback" not in up.log.read_text()


async def planned(url: str, data: Path) -> str:
    """Publish a map and plan a path on it; return the id of the plan."""
    rest = RestClient(url)
    await rest.login("admin", (data / "admin-password").read_text().strip())
    grid = office(seed=1, width=12.0, height=10.0)
    await publish_map(rest, "office", grid)
    start = free_pose(grid, seed=1)
    goal = reachable_pose(grid, start, seed=2, at_least=3.0)
    return str((await rest.plan("office", (start.x, start.y), (goal.x, goal.y)))["plan_id"])


def test_an_interrupt_of_a_serving_cloud_ends_it_cleanly_and_stores_the_last_plan(tmp_path: Path) -> None:
    up = Up(tmp_path)
    up.wait_for(up.ready.exists)
    ready = json.loads(up.ready.read_text())
    assert ready["pid"] == up.process.pid
    assert ready["url"].startswith("http://127.0.0.1:")
    assert ready["admin_user"] == "admin"
    assert stat.S_IMODE((up.folder / "data" / "admin-password").stat().st_mode) == 0o600
    plan = asyncio.run(planned(ready["url"], up.folder / "data"))
    assert up.end(signal.SIGINT) == 0
    assert "Traceback" not in up.log.read_text()
    with contextlib.closing(open_store(f"sqlite://{up.folder / 'data' / 'ppaas.sqlite'}")) as store:
        assert store.plan(plan).id == plan


def test_a_cloud_shuts_others_out_of_its_data_a_second_cloud_and_other_users_of_the_computer(tmp_path: Path) -> None:
    up = Up(tmp_path, "--listen-machines", "127.0.0.1:0")
    up.wait_for(up.ready.exists)
    (tmp_path / "second").mkdir()
    (tmp_path / "second" / "data").symlink_to(tmp_path / "data")
    (tmp_path / "third").mkdir()
    store = ("--store", f"sqlite://{tmp_path}/data/ppaas.sqlite")
    for other, used in ((Up(tmp_path / "second"), "the data folder"), (Up(tmp_path / "third", *store), "the store")):
        assert other.wait() == 1
        (line,) = other.log.read_text().splitlines()
        assert line.startswith(f"ppaas: unavailable: {used}")
        assert f"is in use by process {up.process.pid} of host" in line
        assert not other.ready.exists()
    assert up.process.poll() is None
    assert open_to_others(up) == []
    assert up.end(signal.SIGTERM) == 0
    assert "have access to" not in up.log.read_text()
    assert "Traceback" not in up.log.read_text()


def open_to_others(up: Up) -> list[str]:
    """Return the folders and files of a cloud that other users of the computer may enter or read."""
    made = [up.folder / "data", *(up.folder / "data").rglob("*"), *up.runs.rglob("*")]
    return [str(path) for path in made if path.exists() and stat.S_IMODE(path.stat().st_mode) & 0o077]


@needs_ipv6
def test_a_cloud_listens_at_both_ipv6_and_ipv4_and_names_its_address_in_brackets(tmp_path: Path) -> None:
    up = Up(tmp_path, "--host", "::")
    up.wait_for(up.ready.exists)
    url = json.loads(up.ready.read_text())["url"]
    assert url.startswith("http://[::]:") and f"serving at {url}" in up.log.read_text()
    port = url.rpartition(":")[2]
    for host in ("[::1]", "127.0.0.1"):
        assert asyncio.run(RestClient(f"http://{host}:{port}").get("/v1/health"))["status"]
    assert up.end(signal.SIGTERM) == 0


def test_an_endpoint_whose_keeper_was_killed_before_it_got_its_settings_ends_without_a_word() -> None:
    command = [sys.executable, "-m", serving.__name__]
    ended = subprocess.run(command, check=False, stdin=subprocess.DEVNULL, capture_output=True)
    assert (ended.returncode, ended.stderr) == (serving.NO_SETTINGS, b"")


def test_a_start_error_is_one_line_and_leaves_nothing_behind(tmp_path: Path) -> None:
    up = Up(tmp_path, "--store", "nowhere://")
    assert up.wait() == 1
    assert up.log.read_text().startswith("ppaas: ")
    assert len(up.log.read_text().splitlines()) == 1


def test_an_unwritable_ready_file_ends_the_cloud_with_a_reason(tmp_path: Path) -> None:
    up = Up(tmp_path, "--ready-file", str(tmp_path / "nowhere" / "ready.json"))
    assert up.wait() == 1
    assert "cannot write the ready file" in up.log.read_text()
    assert "Traceback" not in up.log.read_text()


LISTEN = ("--listen-machines", "127.0.0.1:8600")
SECRET, AWAY = ("--standby-secret-file",), ("--master", "127.0.0.1:1")
NOBODY = Ticket("127.0.0.1", 1, "0" * 64, "secret", f"b{STANDBY}")


async def start(data: Path, *arguments: str) -> None:
    """Take the lead as ``ppaas up`` does, and give it up."""
    parser = CommandParser()
    up.configure(parser)
    parsed = parser.parse_args(["--data", str(data), "--port", "0", *arguments])
    async with contextlib.AsyncExitStack() as stack:
        spares = SpareProcesses(COMMAND)
        stack.push_async_callback(spares.close)
        leadership = await take_the_lead(parsed, cloud_config(parsed), spares, stack)
        assert leadership.leads()


# A standby with options that cannot work ends at once with one line.


@pytest.mark.parametrize(
    ("arguments", "error", "why"),
    [
        (("--standby", "--listen-machines", "127.0.0.1:0"), InvalidInput, "a port other than 0"),
        (("--standby", *LISTEN), InvalidInput, "needs a ticket of the leader once"),
        (("--standby", str(NOBODY)), InvalidInput, "give --listen-machines as well"),
        (("--standby", "nonsense", *LISTEN), InvalidInput, "not a ticket"),
        (("--standby", str(NOBODY), *LISTEN), Unavailable, "no answer at tls://127.0.0.1:1"),
        (("--standby", *SECRET, "none", *LISTEN), InvalidInput, "--standby-secret-file needs --master"),
        (("--standby", *SECRET, "none", *AWAY, *LISTEN), InvalidInput, "join secrets in none cannot be read"),
    ],
)
async def test_a_standby_that_cannot_take_over_says_why(
    tmp_path: Path, arguments: tuple[str, ...], error: type[Exception], why: str
) -> None:
    with pytest.raises(error, match=why):
        await asyncio.wait_for(start(tmp_path, *arguments), 60.0)


async def test_a_standby_with_a_secret_begins_a_cloud_that_nobody_has_led_but_no_other(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "secret").write_text("s" * 32)
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
    store = ("--store", f"sqlite:///{tmp_path / 'store.sqlite'}", "--map-store", f"file:///{tmp_path / 'maps'}")
    words = ("--standby", *SECRET, str(tmp_path / "secret"), *AWAY, *LISTEN, *store)
    await asyncio.wait_for(start(tmp_path / "first", *words), 60.0)
    second = asyncio.create_task(start(tmp_path / "second", *words))
    await until(lambda: "waiting for a master that has the files of the cloud" in caplog.text, 60.0)
    assert not second.done(), "its machines know another authority"
    second.cancel()
    await asyncio.gather(second, return_exceptions=True)


@pytest.mark.parametrize("option", ["--join-secret-file", "--standby-secret-file"])
def test_secrets_without_a_port_for_machines_are_refused(
    tmp_path: Path, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["up", "--data", str(tmp_path), option, "secret"]) == 1
    assert f"{option} needs --listen-machines" in capsys.readouterr().err


async def test_the_first_process_leads_at_once_and_the_next_one_after_it(tmp_path: Path) -> None:
    for _ in range(2):
        await asyncio.wait_for(start(tmp_path), 60.0)
        await asyncio.wait_for(start(tmp_path, "--standby"), 60.0)


async def test_a_cloud_that_nobody_has_stood_by_for_leads_with_the_option_too(tmp_path: Path) -> None:
    Authority(tmp_path / MACHINES)
    (tmp_path / MACHINES / ADDRESS).write_text("tls://127.0.0.1:8600")
    await asyncio.wait_for(start(tmp_path, "--standby", *LISTEN), 60.0)
    assert not (tmp_path / MACHINES / ADDRESS).exists(), "a standby makes no tickets"


# Settings of endpoints are those of the options.


@pytest.mark.parametrize(("command", "words"), [(up, []), (machine_join, ["ticket"])])
def test_the_folder_of_the_documentation_site_holds_in_any_working_folder(
    command: object, words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parser = CommandParser()
    command.configure(parser)  # type: ignore[attr-defined]
    monkeypatch.chdir(tmp_path)
    given = parser.parse_args([*words, "--docs-site", "site"])
    assert front_config(given, port=8500).docs_site == str(tmp_path / "site")
    assert front_config(parser.parse_args(words), port=8500).docs_site == ""
