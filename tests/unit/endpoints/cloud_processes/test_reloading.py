"""Reload of settings in a process: checked first, applied to all parts, reported to endpoints and a file, audited."""

import argparse
import asyncio
import os
import signal
from collections.abc import AsyncIterator, Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from endpoints.audit.file_log import AUDIT
from endpoints.cli.settings_tree import TABLES, UP, settled
from endpoints.cloud_processes import reloading
from endpoints.cloud_processes.config import EndpointConfig, settings_at_start, with_settings
from endpoints.cloud_processes.ports import front_config
from endpoints.cloud_processes.reloading import SettingsReload
from endpoints.settings.live import LiveSettings, live_settings
from endpoints.settings.reload import REPORT, ReloadReport, RunningSettings
from endpoints.settings.setting import RELOADED, settings_of
from engine.master.quotas import Quota
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput
from robots.cli.command_parser import CommandParser
from tests.support.waiting import until

Write = Callable[[str], object]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Return a function that writes the file of settings."""
    return (tmp_path / "ppaas.toml").write_text


@pytest.fixture
def running(write: Write, tmp_path: Path) -> RunningSettings:
    write("[up]\n")
    words = ["--config", str(tmp_path / "ppaas.toml"), "--data", str(tmp_path / "var")]
    (tmp_path / "var").mkdir()
    parser = CommandParser()
    TABLES[UP](parser)
    arguments = parser.parse_args(words)
    return RunningSettings(settings_of({UP: TABLES[UP]}), partial(settled, UP, arguments, {}))


@pytest.fixture
async def reload(running: RunningSettings) -> AsyncIterator[SettingsReload]:
    made = SettingsReload(running)
    made.on_hangup(asyncio.Event())
    yield made
    await made.close()


async def test_parts_get_the_settings_at_once_and_after_each_reload(reload: SettingsReload, write: Write) -> None:
    seen: list[float] = []
    reload.follow(lambda now: seen.append(now.idle))
    write("[up]\nidle = 7\n")
    await reload.reload()
    assert seen == [600.0, 7.0]


async def test_endpoints_get_the_settings_when_they_are_not_the_known_ones(
    reload: SettingsReload, write: Write
) -> None:
    known = await reload.changed(None)
    waiting = asyncio.create_task(reload.changed(known))
    write("[up]\nidle = 7\n")  # nothing of theirs
    await reload.reload()
    assert not waiting.done()
    write("[up]\nidle = 7\nallow-origin = ['https://pages.example']\n")
    await reload.reload()
    assert (await waiting).allow_origin == ("https://pages.example",)


async def test_settings_that_do_not_fit_together_change_nothing(reload: SettingsReload, write: Write) -> None:
    write("[up]\nidle = 7\noidc-issuer = 'https://login.example'\n")
    with pytest.raises(InvalidInput, match="oidc"):
        await reload.reload()
    assert reload.arguments.idle == 600.0 and reload.live.oidc is None


async def test_a_secret_that_cannot_be_read_changes_nothing(
    reload: SettingsReload, write: Write, tmp_path: Path
) -> None:
    secret = tmp_path / "secret"
    make = partial(secret.write_text, "of the client")
    provider = "oidc-issuer = 'https://login.example'\noidc-client-id = 'c'\noidc-cloud-url = 'https://cloud.example'\n"
    write(f"[up]\nidle = 7\n{provider}oidc-role = {{a = 'user'}}\noidc-client-secret-file = '{secret}'\n")
    with pytest.raises(InvalidInput, match="secret"):
        await reload.reload()
    make()
    await reload.reload()
    assert reload.live.oidc is not None and reload.live.oidc.secret_file == str(secret)


async def test_a_signal_reloads_and_leaves_a_report_and_an_event(reload: SettingsReload, write: Write) -> None:
    data: Path = reload.arguments.data
    begun = report_in(data)
    assert (begun.pid, begun.changed) == (os.getpid(), [])
    write("[up]\nidle = 7\nport = 8700\n")
    os.kill(os.getpid(), signal.SIGHUP)
    await until(lambda: report_in(data).began > begun.began)
    done = report_in(data)
    assert {(one.key, one.applied) for one in done.changed} == {("up.idle", True), ("up.port", False)}
    write("[up]\nidel = 7\n")
    os.kill(os.getpid(), signal.SIGHUP)
    await until(lambda: report_in(data).began > done.began)
    assert "did you mean idle?" in report_in(data).problem
    assert reload.arguments.idle == 7.0
    events = (data / AUDIT).read_text()
    assert '"changed":{"up.idle":["600.0","7.0"]},"needs_restart":["up.port"]' in events
    assert '"outcome":"refused"' in events


async def test_a_process_whose_terminal_is_gone_ends(running: RunningSettings, monkeypatch: pytest.MonkeyPatch) -> None:
    terminals = [True, True, False]
    monkeypatch.setattr(reloading, "_has_terminal", lambda: terminals.pop(0))
    made, end = SettingsReload(running), asyncio.Event()
    made.on_hangup(end)
    begun = report_in(running.arguments.data)
    os.kill(os.getpid(), signal.SIGHUP)
    await until(lambda: report_in(running.arguments.data).began > begun.began)
    assert not end.is_set()
    os.kill(os.getpid(), signal.SIGHUP)
    await asyncio.wait_for(end.wait(), 10.0)
    await made.close()


def report_in(data: Path) -> ReloadReport:
    return from_json((data / REPORT).read_bytes(), ReloadReport)


OTHER: dict[str, Any] = {
    "allow_origin": ["https://pages.example"], "keep_versions": 3, "log_level": "error", "max_connections": 9,
    "max_connections_per_address": 4, "quota": [("maps", 2)], "trusted_proxy": ["10.0.0.0/8"],
}  # fmt: skip
OF_MASTER = {"idle", "metrics_robots", "retention", "retention_size", "webhook_allow_http", "webhook_allow_private"}
PROVIDER = {name for name in RELOADED[UP] if name.startswith("oidc_")}


def test_each_setting_that_is_reloaded_is_followed_by_somebody(running: RunningSettings) -> None:
    assert OTHER.keys() | OF_MASTER | PROVIDER == RELOADED[UP]


@pytest.mark.parametrize("name", sorted(OTHER))
def test_endpoints_start_with_what_they_follow(running: RunningSettings, name: str) -> None:
    before = live_settings(running.arguments)
    after = live_settings(argparse.Namespace(**vars(running.arguments) | {name: OTHER[name]}))
    assert before != after
    config = endpoint(running.arguments)
    assert settings_at_start(config) == before
    changed = with_settings(config, after)
    assert settings_at_start(changed) == after
    assert with_settings(changed, before) == config


def endpoint(arguments: argparse.Namespace) -> EndpointConfig:
    live: LiveSettings = live_settings(arguments)
    return EndpointConfig(
        name="local-1", machine="local", run_dir="", secret="", store="", map_store="", outbox=None, reserve=None,
        recordings=None, machines=None, listen_machines=None, data="", keep_versions=live.keep_versions,
        quota=Quota(**dict(arguments.quota)), linger=1.0, holder="", orphaned=1.0, allowed=(),
        front=front_config(arguments, port=8500),
    )  # fmt: skip
