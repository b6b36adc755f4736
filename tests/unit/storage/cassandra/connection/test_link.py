"""Connections to a cluster whose nodes come back under other addresses."""

import threading
from typing import Any

import pytest
from cassandra import InvalidRequest, OperationTimedOut, ReadFailure
from cassandra.cluster import NoHostAvailable

from ppaas.errors import Unavailable
from storage.cassandra.connection import link as link_module
from storage.cassandra.connection.address import parse_address
from storage.cassandra.connection.link import SILENCE, ClusterLink, NodeSilence, driver_errors, is_silence
from storage.store_errors import unusable
from tests.support.waiting import wait_until

ADDRESS = parse_address("cassandra://db/ppaas?timeout=0.1")


class FakeSession:
    """A session that prepares statements and notes whether its cluster was shut down."""

    def __init__(self) -> None:
        self.cluster = self
        self.closed = threading.Event()

    def prepare(self, cql: str) -> Any:
        class Statement:
            session = self
            text = cql

        return Statement()

    def shutdown(self) -> None:
        self.closed.set()


class Clusters:
    """What ``connect`` returns, one after the other, and how often it was asked to create the keyspace."""

    def __init__(self) -> None:
        self.next: list[FakeSession | Unavailable] = []
        self.creations: list[bool] = []

    def connect(self, address: object, *, create: bool) -> FakeSession:
        self.creations.append(create)
        found = self.next.pop(0)
        if isinstance(found, Unavailable):
            raise found
        return found


@pytest.fixture
def clusters(monkeypatch: pytest.MonkeyPatch) -> Clusters:
    made = Clusters()
    monkeypatch.setattr(link_module, "connect", made.connect)
    monkeypatch.setattr(link_module, "SILENCE", 0.0)
    return made


def test_silence_lasts_until_a_node_responds() -> None:
    now = [0.0]
    silence = NodeSilence(lambda: now[0])
    assert not silence.begin()
    now[0] = SILENCE - 0.1
    assert not silence.begin()
    silence.end()
    now[0] = SILENCE
    assert not silence.begin(), "a node has responded meanwhile"
    now[0] = 2.0 * SILENCE
    assert silence.begin()
    assert not silence.begin(), "the next attempt is due later"
    now[0] = 3.0 * SILENCE
    assert silence.begin()


def test_the_session_and_its_statements_are_replaced_once_the_cluster_is_reached_again(clusters: Clusters) -> None:
    before, after = FakeSession(), FakeSession()
    clusters.next = [before, after]
    link = ClusterLink(ADDRESS)
    assert link.statement("SELECT 1").session is before
    link.unanswered()
    wait_until(lambda: link.session() is after)
    assert link.statement("SELECT 1").session is after
    assert before.closed.wait(10.0)
    assert not after.closed.is_set()
    link.close()
    assert after.closed.is_set()


def test_the_keyspace_is_not_created_in_the_cluster_that_is_found_later(clusters: Clusters) -> None:
    clusters.next = [FakeSession(), FakeSession()]
    link = ClusterLink(ADDRESS)
    link.session()
    link.unanswered()
    wait_until(lambda: len(clusters.creations) == 2)
    assert clusters.creations == [True, False]
    link.close()


def test_a_cluster_that_is_still_away_leaves_the_session_and_is_asked_again(clusters: Clusters) -> None:
    before, after = FakeSession(), FakeSession()
    clusters.next = [before, unusable(ADDRESS, "no node responds"), after]
    link = ClusterLink(ADDRESS)
    assert link.session() is before

    def again() -> bool:
        link.unanswered()
        return link.session() is after

    wait_until(again)
    assert before.closed.wait(10.0)
    link.close()


def test_a_session_opened_after_the_link_was_closed_is_closed(clusters: Clusters) -> None:
    before, after, go = FakeSession(), FakeSession(), threading.Event()
    clusters.next = [before, after]
    link = ClusterLink(ADDRESS)
    link.session()
    connect = link_module.connect

    def late(*arguments: Any, **options: Any) -> Any:
        assert go.wait(10.0)
        return connect(*arguments, **options)

    link_module.connect = late
    link.unanswered()
    link.close()
    go.set()
    assert after.closed.wait(10.0)
    with pytest.raises(Unavailable, match="closed"):
        link.session()


def test_nothing_is_connected_before_the_first_session(clusters: Clusters) -> None:
    link = ClusterLink(ADDRESS)
    link.unanswered()
    link.close()
    assert clusters.creations == []


def advice(error: Exception) -> str:
    with pytest.raises(Unavailable) as caught, driver_errors("db"):
        raise error
    return str(caught.value)


# Errors of the driver, with advice.


def test_too_many_deleted_rows_come_with_what_to_do() -> None:
    told = advice(ReadFailure("failed", error_code_map={"127.0.0.1": 1}))
    assert "deleted rows" in told
    assert "nodetool compact" in told
    for code in ({"127.0.0.1": 0}, None):
        assert "compact" not in advice(ReadFailure("failed", error_code_map=code))


def test_only_errors_without_a_response_are_silence() -> None:
    assert is_silence(NoHostAvailable("none", {}))
    assert is_silence(OperationTimedOut())
    assert not is_silence(InvalidRequest("no such table"))
    assert not is_silence(ReadFailure("failed"))
    assert not is_silence(None)
