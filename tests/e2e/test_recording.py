"""A drive is recorded, opened by the libraries of others, and replayed; the ring survives a killed clone."""

import asyncio
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from ppaas.maps.grid import GridMap
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from robots.replay.replaying import ReplayOptions, replay
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.cloud.drive import driving
from tests.support.recordings.entries import read
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

ROBOT = "/v1/robots/recorded"
BOTH_WAYS = {"/scan", "/odom", "/cmd_vel", "/amcl_pose", "/map", "/plan", "/move_base/goal", "/move_base/result"}


async def test_drive_is_recorded_and_replayed(cloud: RunningCloud, office_map: GridMap, tmp_path: Path) -> None:
    rest: RestClient = await cloud.admin()
    assert cloud.token is not None
    await publish_map(rest, "recorded-ward", office_map)
    start = free_pose(office_map, seed=3)
    goal = reachable_pose(office_map, start, seed=2, at_least=1.5)
    recorder = {"recorder": {"ring_minutes": 2, "max_mb": 8}}
    file = RobotFile(map="recorded-ward", initial_pose=(start.x, start.y, start.theta), parameters=recorder)
    await rest.put_robot("recorded", file)
    async with driving(cloud.ws_url, cloud.token, "recorded", office_map, start) as drive:
        recording = (await rest.post(f"{ROBOT}/recordings", {"seconds": 300.0}))["id"]
        await drive.go(goal)
        stopped = await rest.post(f"{ROBOT}/recordings/{recording}/stop", {})
        assert stopped["finished"]
        path = tmp_path / "drive.mcap"
        await rest.fetch_to(f"{ROBOT}/recordings/{recording}/file", path)
        _others_read_it(path)
        await asyncio.sleep(2.5)  # the ring is written every two seconds
        cloud.container().kill()
        ring = tmp_path / "ring.mcap"
        await rest.fetch_to(f"{ROBOT}/recordings/ring/file", ring)
        reader, messages = read(ring.read_bytes())
        assert {message.channel.topic for message in messages} >= BOTH_WAYS
        assert reader.metadata["ppaas"]["map"] == "recorded-ward"
        state = await rest.get(f"{ROBOT}/recorder")
        assert (state["recording"], state["problem"]) == ("", "")
    report = await replay(ReplayOptions(path, robot="replayed", cloud=(cloud.url, cloud.token)), lambda _: None)
    assert list(report.comparison.goals.values()) == [("SUCCEEDED", "SUCCEEDED")]
    assert report.comparison.poses > 20
    assert report.comparison.most_distance < 0.1
    assert not report.comparison.differs


def _others_read_it(path: Path) -> None:
    with path.open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    assert summary is not None
    assert {channel.topic for channel in summary.channels.values()} >= BOTH_WAYS
    with AnyReader([path]) as bag:
        scans: list[Any] = [bag.deserialize(raw, of.msgtype) for of, _, raw in bag.messages() if of.topic == "/scan"]
    assert len(scans[0].ranges) == 360
