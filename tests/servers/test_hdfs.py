"""The map store in HDFS beyond the contract of map stores: durability, and repair of interrupted writes."""

import getpass
import hashlib
import http.client
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest
import requests

from engine.agent.layer_builder import LayerBuilder
from engine.agent.map_cache import MapCache
from engine.specs.containers import LayerSpec
from engine.specs.layer_files import open_layers
from ppaas.errors import NotFound, Unavailable
from storage.hdfs.store import HdfsMapStore
from storage.records import Publication
from tests.servers.hdfs_server import HdfsServer
from tests.servers.jars import HDFS, OTHER_HADOOPS
from tests.support.storage.records import found_map, house, pgm, put_map

pytestmark = [
    pytest.mark.servers,
    pytest.mark.parametrize("hdfs_server", [None, *OTHER_HADOOPS], indirect=True, ids=["image", *OTHER_HADOOPS]),
]

OLD, NEW = house(image=pgm(value=0)), house(image=pgm(value=254))


@pytest.fixture
def server(hdfs_server: HdfsServer) -> Iterator[HdfsServer]:
    """Return the server; both daemons are restarted after the test."""
    yield hdfs_server
    hdfs_server.start()


def test_the_version_runs_that_is_asked_for(request: pytest.FixtureRequest, hdfs_server: HdfsServer) -> None:
    of_image = ElementTree.parse(HDFS).getroot().find("{*}properties/{*}hadoop")
    assert of_image is not None
    assert hdfs_server.version() == (request.node.callspec.params["hdfs_server"] or of_image.text)


def test_acknowledged_maps_survive_kills_of_both_daemons(server: HdfsServer, hdfs_store: HdfsMapStore) -> None:
    made = []
    for value in range(8):
        made.append(put_map(hdfs_store, house(image=pgm(value=value)), message=f"walk {value}").present)
        if value == 3:
            server.kill()
            server.start()
    server.kill()
    server.start()
    assert hdfs_store.versions("house") == made[::-1]
    for value in range(8):
        given = house(image=pgm(value=value))
        assert found_map(hdfs_store, version=given.version).files == given.files


@pytest.mark.parametrize("daemon", ["name_node", "data_node"])
def test_publishing_fails_while_a_daemon_is_down_and_works_afterwards(
    server: HdfsServer, hdfs_store: HdfsMapStore, daemon: str
) -> None:
    put_map(hdfs_store, OLD)
    getattr(server, daemon).kill()
    with pytest.raises(Unavailable, match=r"hdfs://.*check that"):
        put_map(hdfs_store, NEW)
    server.start()
    assert found_map(hdfs_store) == OLD
    put_map(hdfs_store, NEW)
    assert found_map(hdfs_store) == NEW


async def test_cached_maps_are_served_while_hdfs_is_down(
    server: HdfsServer, hdfs_store: HdfsMapStore, tmp_path: Path
) -> None:
    put_map(hdfs_store, NEW)
    cache = MapCache(tmp_path / "shm", build=LayerBuilder(hdfs_store))
    cache.release(await cache.ensure(LayerSpec(NEW, 0.18)))
    head = hdfs_store.map_head("house")
    server.kill()
    assert hdfs_store.map_head("house") == head
    folder = await cache.ensure(LayerSpec(NEW, 0.18))
    assert open_layers(folder).grid.data.shape == (3, 4)
    with pytest.raises(Unavailable):
        await cache.ensure(LayerSpec(NEW, 0.35))
    with pytest.raises(Unavailable):
        hdfs_store.map_head("depot")
    server.start()
    await cache.ensure(LayerSpec(NEW, 0.35))
    with pytest.raises(NotFound):
        hdfs_store.map_head("depot")


PUBLISHER = """
import sys
from storage.hdfs.store import HdfsMapStore
from tests.support.storage.records import house, put_map
store = HdfsMapStore(sys.argv[1])
for number in range(1000):
    given = house(image=b"P5\\n1000 1000\\n255\\n" + bytes([number % 2]) * 1_000_000, description=str(number))
    put_map(store, given)
    print(given.version, flush=True)
"""


def test_a_killed_writer_leaves_only_complete_versions(hdfs_server: HdfsServer, hdfs_store: HdfsMapStore) -> None:
    url = hdfs_server.url(hdfs_store._disk._address.path.strip("/"))  # type: ignore[attr-defined]
    for lines in (1, 2, 3):
        command = [sys.executable, "-c", PUBLISHER, url]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as publisher:
            assert publisher.stdout is not None
            published = [publisher.stdout.readline().strip() for _ in range(lines)]
            publisher.send_signal(signal.SIGKILL)
        assert all(published)
        kept = [one.version for one in hdfs_store.versions("house")]
        assert published[-1] in kept[:2]  # it may have published once more before it could print that
        for version in set(kept):
            assert found_map(hdfs_store, version=version).version == version
    put_map(hdfs_store, NEW)
    assert found_map(hdfs_store) == NEW


def test_an_interrupted_write_is_repaired(hdfs_server: HdfsServer, hdfs_store: HdfsMapStore) -> None:
    """A client that disconnects during an upload leaves an open file of length zero, which cannot be read."""
    put_map(hdfs_store, OLD)
    image = hashlib.sha256(NEW.image or b"").hexdigest()
    cut_off(hdfs_server, f"{hdfs_store._disk._address.path}/house/files-1/{image}")  # type: ignore[attr-defined]
    put_map(hdfs_store, NEW)
    assert found_map(hdfs_store) == NEW


def cut_off(server: HdfsServer, path: str) -> None:
    """Announce a file of a thousand bytes, write ten and disconnect."""
    created = server.client()._create(path, overwrite=True)
    host, _, rest = created.headers["location"].removeprefix("http://").partition("/")
    connection = http.client.HTTPConnection(host)
    connection.putrequest("PUT", f"/{rest}")
    connection.putheader("Content-Length", "1000")
    connection.putheader("Content-Type", "application/octet-stream")
    connection.endheaders()
    connection.send(b"half of it")
    connection.close()


def test_a_rollback_survives_kills_of_both_daemons(server: HdfsServer, hdfs_store: HdfsMapStore) -> None:
    put_map(hdfs_store, OLD)
    put_map(hdfs_store, NEW)
    hdfs_store.roll_back(OLD.version, Publication("house", "ann", 9.0, "the door is closed"))
    server.kill()
    server.start()
    assert (hdfs_store.map_head("house").version, hdfs_store.map_head("house").present.restored) == (OLD.version, True)


def test_a_denied_write_names_the_user(hdfs_server: HdfsServer) -> None:
    url = hdfs_server.url("closed").partition("?")[0] + "?user=mallory"
    with pytest.raises(Unavailable, match="give user 'mallory' read and write"):
        put_map(HdfsMapStore(url), NEW)


def test_files_of_a_killed_writer_are_removed_after_a_day(hdfs_server: HdfsServer, hdfs_store: HdfsMapStore) -> None:
    put_map(hdfs_store, OLD)
    client, folder = hdfs_server.client(), f"{hdfs_store._disk._address.path}/.incoming"  # type: ignore[attr-defined]
    for name, age in (("old", 2 * 86400), ("new", 3600)):
        client.write(f"{folder}/{name}", data=b"half")
        client.set_times(f"{folder}/{name}", modification_time=int(1e3 * (time.time() - age)))
    put_map(hdfs_store, NEW)
    assert client.list(folder) == ["new"]


def test_a_write_that_a_quota_stops_leaves_no_part(hdfs_server: HdfsServer, hdfs_store: HdfsMapStore) -> None:
    put_map(hdfs_store, OLD)
    folder = hdfs_store._disk._address.path  # type: ignore[attr-defined]
    incoming = f"{folder}/.incoming"
    set_quota(hdfs_server, folder, 1000)
    with pytest.raises(Unavailable, match="quota of the folder is used up"):
        put_map(hdfs_store, NEW)
    assert hdfs_server.client().list(incoming) == []
    set_quota(hdfs_server, folder, -1)
    put_map(hdfs_store, NEW)
    assert found_map(hdfs_store) == NEW


def test_a_part_that_cannot_be_removed_at_once_is_removed_with_the_next_upload(
    hdfs_server: HdfsServer, hdfs_store: HdfsMapStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    put_map(hdfs_store, OLD)
    disk = hdfs_store._disk
    incoming, delete = f"{disk._address.path}/.incoming", disk._client.delete  # type: ignore[attr-defined]
    cut = iter([b"part"])

    def fail(path: str, **options: object) -> bool:
        if incoming in path:
            raise requests.ConnectionError("cut off")
        return bool(delete(path, **options))

    def broken(path: str, data: object) -> None:
        hdfs_server.client().write(path, data=next(cut))
        raise requests.ConnectionError("cut off")

    with monkeypatch.context() as patch:
        patch.setattr(disk._client, "delete", fail)  # type: ignore[attr-defined]
        patch.setattr(disk._client, "write", broken)  # type: ignore[attr-defined]
        with pytest.raises(Unavailable, match="cannot reach"):
            put_map(hdfs_store, NEW)
    assert len(hdfs_server.client().list(incoming)) == 1
    put_map(hdfs_store, NEW)
    assert hdfs_server.client().list(incoming) == []


def set_quota(server: HdfsServer, folder: str, size: int) -> None:
    """Set the largest size of the files in a folder [bytes]; -1 for no limit."""
    user = {"op": "SETQUOTA", "storagespacequota": size, "user.name": getpass.getuser()}
    requests.put(f"http://127.0.0.1:{server.port}/webhdfs/v1{folder}", params=user, timeout=20).raise_for_status()
