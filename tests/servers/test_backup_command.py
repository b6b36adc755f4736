"""``ppaas backup`` and ``ppaas restore`` between kinds of stores, in a bucket of S3."""

import json
import uuid
from pathlib import Path

import pytest

from robots.cli import main
from storage.urls.opening import open_map_store, open_store
from tests.servers.cassandra_server import CassandraServer
from tests.servers.hdfs_server import HdfsServer
from tests.servers.s3_server import BUCKET, S3Server
from tests.support.storage.full_store import fill, fill_maps

pytestmark = pytest.mark.servers


@pytest.fixture
def bucket(s3_server: S3Server, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the URL of a new prefix in a bucket, with credentials in the environment."""
    for name, value in s3_server.environment().items():
        monkeypatch.setenv(name, value)
    return f"s3://{BUCKET}/{uuid.uuid4().hex}"


def test_a_cloud_on_cassandra_and_hdfs_is_restored_into_files(
    cassandra_server: CassandraServer,
    hdfs_server: HdfsServer,
    bucket: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    name = uuid.uuid4().hex[:8]
    urls = cassandra_server.url(f"backed_{name}"), hdfs_server.url(f"backed-{name}")
    store = open_store(urls[0])
    fill(store)
    store.close()
    fill_maps(open_map_store(urls[1]))
    key = ["--key-file", str(tmp_path / "key")]
    for _ in range(2):
        assert main.main(["backup", bucket, "--store", urls[0], "--map-store", urls[1], *key, "--json"]) == 0
    [again] = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert (again["records"]["plans"], again["stores"]) == (80, {"store": "cassandra", "map_store": "hdfs"})
    assert main.main(["backup", "check", bucket, *key]) == 0
    assert main.main(["restore", bucket, *key, "--data", str(tmp_path / "data")]) == 0
    assert main.main(["store", "check", urls[0], f"sqlite://{tmp_path}/data/ppaas.sqlite"]) == 0
    assert main.main(["store", "check", urls[1], f"file://{tmp_path}/data/maps"]) == 0


def test_wrong_credentials_are_reported_by_the_place(
    bucket: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "wrong")
    assert main.main(["backup", "list", bucket]) == 1
    assert f"backups at {bucket}:" in capsys.readouterr().err
