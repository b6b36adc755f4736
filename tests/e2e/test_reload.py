"""Settings are reloaded in a running cloud of two endpoints, which keep their sockets, and in its standby."""

import asyncio
import json
import signal
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import httpx
import pytest
from websockets.asyncio.client import connect

from ppaas.errors import QuotaExceeded
from ppaas.maps.grid import GridMap
from robots import cli
from robots.client.rest import RestClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.standby_process import standing_by
from tests.support.identity.identity_server import IdentityServer, identity_server
from tests.support.waiting import PATIENCE, patience, until
from tests.support.world.places import free_pose

pytestmark = pytest.mark.journey

PAGE = "https://pages.example"


async def reload(data: Path, *words: str, status: int = 0) -> str:
    """Return what ``ppaas config reload`` prints."""
    command = [sys.executable, "-m", cli.__name__, "config", "reload", "--data", str(data), *words]
    pipe = asyncio.subprocess.PIPE
    process = await asyncio.create_subprocess_exec(*command, stdout=pipe, stderr=pipe)
    out, err = await process.communicate()
    assert process.returncode == status, err.decode()
    return (out or err).decode()


def settings_with(idp: IdentityServer, folder: Path) -> str:
    """Return settings with a quota of one robot, a provider, an allowed page, a retention and another linger."""
    (folder / "secret").write_text("secret of the client")
    return f"""
[up]
port = 1  # the option of the test goes before it
linger = 9
endpoints = 2
quota = {{robots = 1}}
retention = {{audit = 90}}
allow-origin = ["{PAGE}"]
log-level = "debug"
oidc-issuer = "{idp.issuer}"
oidc-client-id = "ppaas"
oidc-client-secret-file = "{folder}/secret"
oidc-cloud-url = "https://cloud.example"
oidc-role = {{staff = "user"}}
oidc-name = "the lab"
"""


async def seen(cloud: RunningCloud) -> tuple[set[str | None], set[str | None]]:
    """Return what twenty connections, which come to all endpoints, see: the provider and the allowed page."""
    providers, pages = set[str | None](), set[str | None]()
    for _ in range(20):
        async with httpx.AsyncClient(base_url=cloud.url, timeout=PATIENCE) as client:
            answer = await client.get("/v1/oidc", headers={"Origin": PAGE})
            providers.add(answer.json()["name"])
            pages.add(answer.headers.get("access-control-allow-origin"))
    return providers, pages


async def days(rest: RestClient) -> dict[str, float | None]:
    return {one["kind"]: one["days"] for one in await rest.get("/v1/retention")}


async def events(rest: RestClient) -> list[dict[str, Any]]:
    """Return the events of reloads, oldest first."""
    return (await rest.items("/v1/audit", action="reload_settings"))[::-1]


async def check_new_settings(cloud: RunningCloud, rest: RestClient) -> None:
    async with patience(20.0):
        while await seen(cloud) != ({"the lab"}, {PAGE}):
            await asyncio.sleep(0.05)
    assert (await days(rest))["audit"] == 90.0


async def test_a_cloud_and_its_standby_take_new_settings_without_a_restart(tmp_path: Path, office_map: GridMap) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    stores = ("--store", f"sqlite:///{tmp_path / 'store.sqlite'}", "--map-store", f"file:///{tmp_path / 'maps'}")
    for folder in (first, second):
        folder.mkdir()
        (folder / "ppaas.toml").write_text("[up]\nendpoints = 2\n")
    async with identity_server() as idp:
        with ExitStack() as processes:
            leading = processes.enter_context(standing_by(first, *stores, "--config", str(first / "ppaas.toml")))
            cloud = await leading.leads()
            standby = standing_by(second, "--standby", *stores, "--config", str(second / "ppaas.toml"))
            heir = processes.enter_context(standby)
            rest = await cloud.admin()
            await publish_map(rest, "office", office_map)
            pose = free_pose(office_map, seed=3)
            token = await register_robot(rest, "tb1", "office", pose)
            async with connect(f"{cloud.ws_url}/?robot=tb1&token={token}") as socket:
                pids = {each.pid for each in leading.endpoints()}
                assert await seen(cloud) == ({None}, {None})
                (first / "ppaas.toml").write_text(settings_with(idp, first))
                report = {one["key"]: one for one in json.loads(await reload(first / "data", "--json"))["changed"]}
                assert (report["up.quota"]["after"], report["up.quota"]["applied"]) == ('{"robots": 1}', True)
                assert [key for key, one in report.items() if not one["applied"]] == ["up.linger"]
                await check_new_settings(cloud, rest)
                await asyncio.wait_for(await socket.ping(), PATIENCE)
                assert {each.pid for each in leading.endpoints()} == pids
                with pytest.raises(QuotaExceeded):
                    await register_robot(rest, "tb2", "office", pose)
                (first / "ppaas.toml").write_text("[up]\nendpoints = 3\nquota = {}\nretenton = {}\n")
                assert "did you mean retention?" in await reload(first / "data", status=1)
                assert await seen(cloud) == ({"the lab"}, {PAGE})
                lost = leading.endpoints()[0]
                lost.kill()
                await until(lambda: len(set(leading.endpoints()) - {lost}) == 2, 30.0)
                await check_new_settings(cloud, rest)
            done, refused = await events(rest)
            assert (done["outcome"], done["details"]["changed"]["up.quota"]) == ("ok", ["{}", '{"robots": 1}'])
            assert (refused["outcome"], refused["reason"]) == ("refused", "invalid-input")
            await heir.stands_by()
            (second / "ppaas.toml").write_text(settings_with(idp, second))
            assert "up.quota: {} -> " in await reload(second / "data")
            leading.process.send_signal(signal.SIGTERM)
            assert await leading.has_ended() == 0
            cloud = await heir.leads()
            await check_new_settings(cloud, await cloud.admin())
