"""Maps in HDFS: URLs of folders."""

import getpass

import pytest

pytest.importorskip("hdfs")

from benchmarks.harness.free_ports import free_ports
from ppaas.errors import InvalidInput, NotFound, Unavailable
from storage.hdfs.store import HdfsAddress, HdfsMapStore


@pytest.mark.parametrize(
    ("url", "host", "path", "user"),
    [
        ("hdfs://nn/maps", "nn:9870", "/maps", None),
        ("hdfs://nn:50070/a/b%20c/?user=ann", "nn:50070", "/a/b c", "ann"),
        ("hdfs://[::1]/maps", "[::1]:9870", "/maps", None),
    ],
)
def test_a_url_names_host_folder_and_user(url: str, host: str, path: str, user: str | None) -> None:
    assert HdfsAddress.parse(url) == HdfsAddress(host, path, user or getpass.getuser())


@pytest.mark.parametrize(
    "url",
    [
        *("hdfs:", "hdfs:///maps", "hdfs://nn", "hdfs://nn/", "hdfs://nn/a//b", "hdfs://nn/a/../b", "hdfs://nn:x/maps"),
        *(
            "hdfs://nn/%23LATEST",
            "hdfs://nn/a?user=",
            "hdfs://nn/a?user=b&user=c",
            "hdfs://nn/a?x=1",
            "hdfs://nn/a?user",
        ),
        *("hdfs://nn/a#b", "hdfs://ann:pw@nn/a", "hdfs://[nn/a", "hdfs://nn:99999/a"),
    ],
)
def test_a_url_without_a_valid_folder_is_refused(url: str) -> None:
    with pytest.raises(InvalidInput):
        HdfsMapStore(url)


def test_an_unreachable_namenode_is_unavailable_with_advice() -> None:
    (port,) = free_ports(1)
    store = HdfsMapStore(f"hdfs://127.0.0.1:{port}/maps")
    calls = [store.maps, lambda: store.map_head("house"), lambda: store.stage().__enter__()]
    for call in calls:
        with pytest.raises(Unavailable, match=f"127.0.0.1:{port}/maps: cannot reach the NameNode.*both are running"):
            call()


def test_invalid_names_are_refused_before_a_request_is_sent() -> None:
    store = HdfsMapStore("hdfs://nowhere.invalid/maps")
    with pytest.raises(InvalidInput):
        store.map_head("../etc")
    with pytest.raises((NotFound, Unavailable)):
        store.map_head("house")
