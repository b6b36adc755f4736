"""URLs of Cassandra stores."""

import ssl
from pathlib import Path

import pytest
from cassandra import ConsistencyLevel

from ppaas.errors import InvalidInput
from storage.cassandra.connection.address import Tls, parse_address
from storage.cassandra.connection.cluster import cluster_of, ssl_context


def test_a_host_and_a_keyspace_are_enough() -> None:
    address = parse_address("cassandra://db/ppaas")
    assert (address.hosts, address.port, address.keyspace) == (("db",), 9042, "ppaas")
    assert (address.user, address.password) == (None, None)
    assert address.replication == {"class": "SimpleStrategy", "replication_factor": 1}


def test_all_settings_are_parsed() -> None:
    url = "cassandra://ann:p%40ss@a,b:9142,[::1]:9142/fleet?replication=x:3,y:2&consistency=QUORUM&timeout=2&granularity=4"
    address = parse_address(url)
    assert (address.hosts, address.port, address.keyspace) == (("a", "b", "::1"), 9142, "fleet")
    assert (address.user, address.password) == ("ann", "p@ss")
    assert address.replication == {"class": "NetworkTopologyStrategy", "x": 3, "y": 2}
    assert (address.consistency, address.timeout, address.granularity) == ("quorum", 2.0, 4)


def test_the_default_is_one_replica_per_host_up_to_three() -> None:
    assert parse_address("cassandra://a,b,c,d/ppaas").replication["replication_factor"] == 3


def test_the_password_is_not_shown() -> None:
    assert str(parse_address("cassandra://ann:secret@db/ppaas")) == "cassandra://db:9042/ppaas"


def test_tls_settings_are_parsed() -> None:
    assert parse_address("cassandra://db/ppaas").tls is None
    assert parse_address("cassandra://db/ppaas?tls=yes").tls == Tls()
    url = "cassandra://db/ppaas?tls=any_name&ca=/a.pem&certificate=/b.pem&key=/c.pem&data_centre=east"
    address = parse_address(url)
    assert address.tls == Tls(check_name=False, ca="/a.pem", certificate="/b.pem", key="/c.pem")
    assert address.data_centre == "east"


def test_host_names_in_certificates_are_checked_by_default(tmp_path: Path) -> None:
    assert ssl_context(Tls()).check_hostname
    lax = ssl_context(Tls(check_name=False))
    assert not lax.check_hostname
    assert lax.verify_mode == ssl.CERT_REQUIRED
    missing = str(tmp_path / "none.pem")
    empty = tmp_path / "empty.pem"
    empty.touch()
    for tls in (Tls(ca=missing), Tls(ca=str(empty)), Tls(certificate=missing), Tls(certificate=str(empty))):
        with pytest.raises(InvalidInput, match="give PEM files"):
            ssl_context(tls)


def test_settings_reach_the_driver() -> None:
    settings = "tls=yes&data_centre=east&consistency=all&timeout=2"
    cluster = cluster_of(parse_address(f"cassandra://ann:p@127.0.0.1,127.0.0.2:9142/ppaas?{settings}"))
    profile, hosts = cluster.profile_manager.default, ("127.0.0.1", "127.0.0.2")
    assert (cluster.contact_points, cluster.port, cluster.auth_provider.username) == (hosts, 9142, "ann")
    assert cluster.ssl_context.check_hostname
    assert profile.load_balancing_policy._child_policy.local_dc == "east"
    assert (profile.consistency_level, profile.request_timeout) == (ConsistencyLevel.ALL, 2.0)


@pytest.mark.parametrize(
    ("url", "error"),
    [
        ("cassandra:///ppaas", "host"),
        ("cassandra://db", "keyspace"),
        ("cassandra://db/A", "keyspace"),
        ("cassandra://db/a/b", "keyspace"),
        ("cassandra://a:1,b:2/ppaas", "one port"),
        ("cassandra://a:0/ppaas", "one port"),
        ("cassandra://a:99999/ppaas", "one port"),
        ("cassandra://a b/ppaas", "host"),
        ("cassandra://[x/ppaas", "host"),
        ("cassandra://a℀b/ppaas", "not a URL"),
        ("cassandra://db/ppaas?colour=red", "unknown setting"),
        ("cassandra://db/ppaas?consistency=most", "known: one"),
        ("cassandra://db/ppaas?replication=0", "replicas"),
        ("cassandra://db/ppaas?replication=x:'},", "replicas"),
        ("cassandra://db/ppaas?timeout=nan", "timeout"),
        ("cassandra://db/ppaas?timeout=0", "timeout"),
        ("cassandra://db/ppaas?granularity=many", "granularity"),
        ("cassandra://db/ppaas?granularity=1", "granularity"),
        ("cassandra://db/ppaas?data_centre=a'b", "nodetool"),
        ("cassandra://db/ppaas?tls=perhaps", "any_name"),
        ("cassandra://db/ppaas?ca=/a.pem", "tls=yes"),
        ("cassandra://db/ppaas?tls=yes&key=/a.pem", "certificate"),
    ],
)
def test_an_invalid_url_is_refused(url: str, error: str) -> None:
    with pytest.raises(InvalidInput, match=error) as caught:
        parse_address(url.replace("://", "://ann:secret@", 1) if "///" not in url and "[x" not in url else url)
    assert "secret" not in str(caught.value)


def test_compression_is_off_whatever_libraries_are_installed() -> None:
    assert cluster_of(parse_address("cassandra://127.0.0.1/ppaas")).compression is False
