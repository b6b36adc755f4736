"""Recordings of a robot over REST: rights, files with the topics that a caller may have, and faults."""

import asyncio
import contextlib
import gc
import stat
import tempfile
from pathlib import Path

import httpx
import pytest

from endpoints.resources.services import Services
from ppaas.errors import Conflict
from ppaas.messages.health.watching import RecorderState, StartRecordingRequest
from storage.recordings import RecordingsFolder
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.support.recordings.entries import entry, mcap, read, scan, text, twist
from tests.support.waiting import until
from tests.unit.endpoints.conftest import LogIn, Publish

ID = "20261126T224142Z"
RECORDINGS = "/v1/robots/tb1/recordings"
SHARED = "/v1/robots/ann:tb1/recordings"
DRIVE = (text("map_name", "house"), entry("scan", scan(1), 1), entry("cmd_vel", twist(), 2, up=False))


@pytest.fixture
def services(services: Services, tmp_path: Path) -> Services:
    object.__setattr__(services, "recordings", RecordingsFolder(tmp_path / "recordings"))
    return services


@pytest.fixture
async def ann(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> dict[str, str]:
    """Return the headers of the owner of robot tb1."""
    headers = await log_in("ann")
    await publish(headers)
    await client.put("/v1/robots/tb1", headers=headers, json={"map": "house"})
    return headers


@pytest.fixture
def folder(services: Services) -> Path:
    assert services.recordings is not None
    robot = services.recordings.of_robot("ann", "tb1")
    (robot / "ring").mkdir(parents=True)
    return robot


def topics(data: bytes) -> list[str]:
    return [message.channel.topic for message in read(data)[1]]


async def test_start_and_stop(client: httpx.AsyncClient, cloud: FakeCloud, ann: dict[str, str], folder: Path) -> None:
    states = {"start": RecorderState(ID), "stop": RecorderState(), "state": RecorderState(ID, 60.0)}

    def recorder(service: str) -> RecorderState:
        if service == "start":
            (folder / f"{ID}.partial").write_bytes(mcap(*DRIVE, finish=False))
        if service == "stop":
            (folder / f"{ID}.partial").rename(folder / f"{ID}.mcap")
        return states[service]

    cloud.recorder = recorder
    started = await client.post(RECORDINGS, headers=ann, json={"seconds": 60.0, "topics": ["scan"]})
    assert (started.status_code, started.json()["id"], started.json()["finished"]) == (201, ID, False)
    assert cloud.recorder_calls[0][3] == StartRecordingRequest(60.0, ["scan"])
    shown = (await client.get("/v1/robots/tb1/recorder", headers=ann)).json()
    assert (shown["recording"], shown["left"]) == (ID, 60.0)
    stopped = await client.post(f"{RECORDINGS}/{ID}/stop", headers=ann)
    assert (stopped.status_code, stopped.json()["finished"]) == (200, True)


async def test_machine_that_does_not_record_says_why(
    client: httpx.AsyncClient, cloud: FakeCloud, ann: dict[str, str]
) -> None:
    cloud.recorder = lambda _: RecorderState(ID, problem="the disk of the cloud is full")
    answer = await client.post(RECORDINGS, headers=ann, json={})
    assert "the disk of the cloud is full" in problem_of(answer, 503, "unavailable")["detail"]


async def test_errors_of_the_recorder_are_problems(
    client: httpx.AsyncClient, cloud: FakeCloud, ann: dict[str, str]
) -> None:
    assert (await client.post(RECORDINGS, headers=ann, json={})).status_code == 503  # it has no container

    def busy(_: str) -> RecorderState:
        raise Conflict("a recording is in progress")

    cloud.recorder = busy
    assert (await client.post(RECORDINGS, headers=ann, json={})).status_code == 409
    for wrong in ({"seconds": 0}, {"seconds": 1e9}, {"topics": ["a b"]}, {"x": 1}):
        assert (await client.post(RECORDINGS, headers=ann, json=wrong)).status_code == 422


async def test_recordings_are_listed_in_pages_and_deleted(
    client: httpx.AsyncClient, ann: dict[str, str], folder: Path
) -> None:
    for second in range(3):
        (folder / f"20261126T22414{second}Z.mcap").write_bytes(mcap(*DRIVE))
    page = (await client.get(RECORDINGS, headers=ann, params={"limit": 2})).json()
    assert [one["id"] for one in page["items"]] == ["20261126T224142Z", "20261126T224141Z"]
    rest = (await client.get(RECORDINGS, headers=ann, params={"cursor": page["next"]})).json()
    assert [one["id"] for one in rest["items"]] == ["20261126T224140Z"]
    assert (await client.delete(f"{RECORDINGS}/{ID}", headers=ann)).status_code == 204
    assert (await client.delete(f"{RECORDINGS}/{ID}", headers=ann)).status_code == 404
    assert (await client.get(f"{RECORDINGS}/{ID}", headers=ann)).status_code == 404


async def test_file_and_a_range_of_it(client: httpx.AsyncClient, ann: dict[str, str], folder: Path) -> None:
    content = mcap(*DRIVE)
    (folder / f"{ID}.mcap").write_bytes(content)
    whole = await client.get(f"{RECORDINGS}/{ID}/file", headers=ann)
    assert whole.content == content
    assert whole.headers["content-disposition"] == f'attachment; filename="tb1-{ID}.mcap"'
    part = await client.get(f"{RECORDINGS}/{ID}/file", headers=ann | {"Range": "bytes=0-7"})
    assert (part.status_code, part.content) == (206, content[:8])


@pytest.mark.parametrize("finished", [True, False], ids=["the file itself", "a copy"])
@pytest.mark.parametrize("wanted", ["bytes=999999999-", "bytes=-0", "bytes=abc", "items=0-3", "bytes=5-2", "bytes=0-3"])
async def test_no_range_leaves_a_file(
    client: httpx.AsyncClient,
    ann: dict[str, str],
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    wanted: str,
    finished: bool,
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "tmp"))
    (tmp_path / "tmp").mkdir()
    (folder / f"{ID}.{'mcap' if finished else 'partial'}").write_bytes(mcap(*DRIVE, finish=finished))
    before = open_files()
    whole = await client.get(f"{RECORDINGS}/{ID}/file", headers=ann)
    answer = await client.get(f"{RECORDINGS}/{ID}/file", headers=ann | {"Range": wanted})
    if wanted in ("bytes=999999999-", "bytes=-0"):
        problem_of(answer, 416, "range-not-satisfiable")
        assert answer.headers["content-range"] == f"bytes */{len(whole.content)}"
    elif wanted == "bytes=0-3":
        assert (answer.status_code, answer.content) == (206, whole.content[:4])
    else:
        assert (answer.status_code, answer.content) == (200, whole.content)
    assert await asyncio.to_thread(lambda: list((tmp_path / "tmp").iterdir())) == []
    assert open_files() == before


def open_files() -> int:
    """Return the number of regular files that this process has open."""
    gc.collect()
    found = 0
    for descriptor in Path("/proc/self/fd").iterdir():
        with contextlib.suppress(OSError):
            found += stat.S_ISREG(descriptor.stat().st_mode)
    return found


async def test_a_copy_keeps_its_turn_until_it_has_been_sent(
    client: httpx.AsyncClient, services: Services, ann: dict[str, str], folder: Path
) -> None:
    (folder / f"{ID}.partial").write_bytes(mcap(*DRIVE, finish=False))
    async with services.copies.turn_of_user("ann"), services.copies.turn_of_user("ann"):
        third = asyncio.create_task(client.get(f"{RECORDINGS}/{ID}/file", headers=ann))
        await until(lambda: services.copies._users["ann"].waiting == 3)
        assert not third.done()
    assert (await third).status_code == 200
    assert services.copies._users == {}


async def test_recording_that_was_cut_off_is_put_together(
    client: httpx.AsyncClient, ann: dict[str, str], folder: Path
) -> None:
    (folder / f"{ID}.partial").write_bytes(mcap(*DRIVE, finish=False))
    answer = await client.get(f"{RECORDINGS}/{ID}/file", headers=ann)
    reader, messages = read(answer.content)
    assert (len(messages), reader.cut) == (3, False)


async def test_last_minutes(client: httpx.AsyncClient, ann: dict[str, str], folder: Path) -> None:
    assert (await client.get(f"{RECORDINGS}/ring/file", headers=ann)).status_code == 404
    (folder / "ring" / "1800000000000000000.mcap").write_bytes(mcap(*DRIVE))
    (folder / "ring" / "1800000020000000000.mcap").write_bytes(mcap(DRIVE[1], finish=False))
    answer = await client.get(f"{RECORDINGS}/ring/file", headers=ann)
    assert topics(answer.content) == ["/map_name", "/scan", "/scan", "/cmd_vel"]  # by time
    assert (await client.get(f"{RECORDINGS}/ring", headers=ann)).json()["id"] == "ring"
    assert (await client.get(f"{RECORDINGS}/ring/file", headers=ann, params={"minutes": 0})).status_code == 422
    assert (await client.delete(f"{RECORDINGS}/ring", headers=ann)).status_code == 204
    assert not await asyncio.to_thread((folder / "ring").exists)


async def test_share_gets_its_topics_only(
    client: httpx.AsyncClient, log_in: LogIn, ann: dict[str, str], folder: Path
) -> None:
    (folder / f"{ID}.mcap").write_bytes(mcap(*DRIVE))
    bob = await log_in("bob")
    assert (await client.get(f"{SHARED}/{ID}/file", headers=bob)).status_code == 404
    share = {"role": "look", "subscribe": ["scan", "map*"]}
    await client.put("/v1/robots/tb1/shares/bob", headers=ann, json=share)
    assert topics((await client.get(f"{SHARED}/{ID}/file", headers=bob)).content) == ["/map_name", "/scan"]
    assert (await client.post(SHARED, headers=bob, json={})).status_code == 403
    assert (await client.post(f"{SHARED}/{ID}/stop", headers=bob)).status_code == 403
    assert (await client.delete(f"{SHARED}/{ID}", headers=bob)).status_code == 403
    assert (await client.get(f"{RECORDINGS}/{ID}", headers=ann)).status_code == 200


async def test_recordings_end_with_their_robot(client: httpx.AsyncClient, ann: dict[str, str], folder: Path) -> None:
    (folder / f"{ID}.mcap").write_bytes(mcap(*DRIVE))
    assert (await client.delete("/v1/robots/tb1", headers=ann)).status_code == 204
    assert not await asyncio.to_thread(folder.exists)


async def test_cloud_without_a_folder_keeps_none(
    client: httpx.AsyncClient, services: Services, ann: dict[str, str]
) -> None:
    object.__setattr__(services, "recordings", None)
    assert (await client.get(RECORDINGS, headers=ann)).status_code == 503
