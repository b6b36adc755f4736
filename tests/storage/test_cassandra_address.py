"""What a URL of a Cassandra says."""

import pytest

from ppaas.errors import InvalidInput
from storage.cassandra_address import parse_address


def test_a_host_and_a_keyspace_are_enough() -> None:
    address = parse_address("cassandra://db/ppaas")
    assert (address.hosts, address.port, address.keyspace) == (("db",), 9042, "ppaas")
    assert (address.user, address.password) == (None, None)
    assert address.replication == {"class": "SimpleStrategy", "replication_factor": 1}


def test_all_can_be_said() -> None:
    url = "cassandra://ann:p%40ss@a,b:9142,[::1]:9142/fleet?replication=x:3,y:2&consistency=QUORUM&timeout=2&granularity=4"
    address = parse_address(url)
    assert (address.hosts, address.port, address.keyspace) == (("a", "b", "::1"), 9142, "fleet")
    assert (address.user, address.password) == ("ann", "p@ss")
    assert address.replication == {"class": "NetworkTopologyStrategy", "x": 3, "y": 2}
    assert (address.consistency, address.timeout, address.granularity) == ("quorum", 2.0, 4)


def test_of_several_hosts_up_to_three_keep_a_copy() -> None:
    assert parse_address("cassandra://a,b,c,d/ppaas").replication["replication_factor"] == 3


def test_the_password_is_not_told() -> None:
    assert str(parse_address("cassandra://ann:secret@db/ppaas")) == "cassandra://db:9042/ppaas"


@pytest.mark.parametrize(
    ("url", "told"),
    [
        ("cassandra:///ppaas", "host"),
        ("cassandra://db", "keyspace"),
        ("cassandra://db/A", "keyspace"),
        ("cassandra://db/a/b", "keyspace"),
        ("cassandra://a:1,b:2/ppaas", "one port"),
        ("cassandra://a:0/ppaas", "one port"),
        ("cassandra://a:99999/ppaas", "one port"),
        ("cassandra://a b/ppaas", "host"),
        ("cassandra://[x/ppaas", "no URL"),
        ("cassandra://db/ppaas?colour=red", "unknown setting"),
        ("cassandra://db/ppaas?consistency=most", "known: one"),
        ("cassandra://db/ppaas?replication=0", "copies"),
        ("cassandra://db/ppaas?replication=x:'},", "copies"),
        ("cassandra://db/ppaas?timeout=nan", "timeout"),
        ("cassandra://db/ppaas?timeout=0", "timeout"),
        ("cassandra://db/ppaas?granularity=many", "granularity"),
    ],
)
def test_what_it_cannot_be_is_refused(url: str, told: str) -> None:
    with pytest.raises(InvalidInput, match=told) as caught:
        parse_address(url.replace("://", "://ann:secret@", 1) if "///" not in url and "[x" not in url else url)
    assert "secret" not in str(caught.value)
