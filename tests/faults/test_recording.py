"""SIGKILL of the recorder of a machine while a robot drives: the robot notices nothing, and the recording goes on."""

import signal
from pathlib import Path

import pytest

from engine.recorder import main as recorder_main
from ppaas.maps.grid import GridMap
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.recordings.entries import read
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

RECORDINGS = "/v1/robots/filmed/recordings"


async def test_recorder_that_is_killed_is_started_again(
    cloud: RunningCloud, office_map: GridMap, tmp_path: Path
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=32)
    token = await register_robot(rest, "filmed", "office", start)
    folder = tmp_path / "data" / "recordings" / "admin" / "filmed"
    async with driving(cloud.ws_url, token, "filmed", office_map, start) as drive:
        recording = (await rest.post(RECORDINGS, {"seconds": 600.0}))["id"]
        await until(lambda: (folder / f"{recording}.partial").stat().st_size > 20_000)
        [recorder] = cloud.find(recorder_main.__name__)
        recorder.send_signal(signal.SIGKILL)
        assert await drive.go(reachable_pose(office_map, start, seed=42, at_least=1.5, at_most=3.0)) < 0.5
        await until((folder / f"{recording}-2.partial").exists)
        await rest.post(f"{RECORDINGS}/{recording}/stop", {})
    await until((folder / f"{recording}-2.mcap").exists)
    for name in (recording, f"{recording}-2"):
        path = tmp_path / f"{name}.mcap"
        await rest.fetch_to(f"{RECORDINGS}/{name}/file", path)
        reader, messages = read(path.read_bytes())
        assert {message.channel.topic for message in messages} >= {"/map", "/scan", "/odom", "/amcl_pose"}
        assert not reader.cut
