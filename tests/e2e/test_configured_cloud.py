"""A cloud that takes its settings from a file, variables and options, and drives a robot."""

import asyncio
import json
import signal
from pathlib import Path

import pytest

from ppaas.maps.generate import office
from robots.client.rest import RestClient
from tests.support.cloud.cloud import publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.cloud.up_process import Up
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

PASSWORD = "correct horse battery"


async def drive_one_robot(url: str) -> None:
    """Log in with the password of the settings, and drive a robot to a goal."""
    admin = RestClient(url)
    await admin.login("admin", PASSWORD)
    grid = office(seed=1, width=12.0, height=10.0)
    await publish_map(admin, "office", grid)
    start = free_pose(grid, seed=1)
    token = await register_robot(admin, "tb1", "office", (start.x, start.y, start.theta))
    async with driving(url, token, "tb1", grid, start) as drive:
        assert await drive.go(reachable_pose(grid, start, seed=2, at_least=1.0, at_most=3.0)) < 0.5


def test_a_cloud_of_a_file_of_settings_drives_a_robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "password").write_text(PASSWORD)
    (tmp_path / "password").chmod(0o600)
    (tmp_path / "store.url").write_text(f"sqlite://{tmp_path}/elsewhere.sqlite")
    (tmp_path / "store.url").chmod(0o600)
    (tmp_path / "ppaas.toml").write_text(f"""
[up]
host = "192.0.2.1"  # of no computer: the variable goes before it
port = 1  # as does the option of the test
endpoints = 2
store-file = "{tmp_path}/store.url"
admin-password-file = "{tmp_path}/password"
quota = {{robots = 1}}
""")
    monkeypatch.setenv("PPAAS_HOST", "127.0.0.1")
    monkeypatch.setenv("PPAAS_MAP_STORE", f"file://{tmp_path}/maps")
    up = Up(tmp_path, "--config", str(tmp_path / "ppaas.toml"))
    up.wait_for(up.ready.exists)
    assert f"settings of {tmp_path}/ppaas.toml" in up.log.read_text()
    url = json.loads(up.ready.read_text())["url"]
    assert url.startswith("http://127.0.0.1:")
    assert len(up.children("endpoints.cloud_processes.serving")) == 2
    asyncio.run(drive_one_robot(url))
    for child in up.children():
        assert b"PPAAS_MAP_STORE" not in Path(f"/proc/{child.pid}/environ").read_bytes()
    assert (tmp_path / "elsewhere.sqlite").stat().st_size > 0 and not (tmp_path / "data" / "ppaas.sqlite").exists()
    assert list((tmp_path / "maps").iterdir())
    assert up.end(signal.SIGTERM) == 0


def test_a_cloud_of_a_misspelt_setting_does_not_start(tmp_path: Path) -> None:
    (tmp_path / "ppaas.toml").write_text("[up]\nendpionts = 2\n")
    up = Up(tmp_path, "--config", str(tmp_path / "ppaas.toml"))
    assert up.wait() == 1
    assert up.log.read_text() == (
        f"ppaas: invalid-input: {tmp_path}/ppaas.toml:2: up.endpionts is unknown: did you mean endpoints?\n"
    )
