"""Leases of local nodes: requests to the node monitor, and the states in them."""

from typing import Any

import pytest

from ppaas.change_log import LogChange, LogEntry
from ppaas.errors import Unavailable
from ppaas.messages.ppaas_msgs import HoldNodeResponse, TopicMessage
from robots.onboard.executor.protocol import NodeReport
from robots.onboard.node_leases import NodeLeases
from robots.onboard.node_monitor_client import NodeSnapshot

MISSED = TopicMessage("move_base/cancel", "{}")


class FakeMonitor:
    """Node monitor that numbers its leases, and records the calls."""

    def __init__(self) -> None:
        self.calls: list[tuple[object, ...]] = []
        self.known: dict[str, int] = {}
        self.reachable = True

    async def take_node(self, node: str) -> HoldNodeResponse:
        self.known[node] = len(self.known) + 1
        return HoldNodeResponse(self.known[node], "taken")

    async def hold_node(self, node: str, lease: int, state: NodeReport, heard: list[str]) -> HoldNodeResponse:
        self.calls.append((node, lease, state.state, state.seconds, heard))
        return HoldNodeResponse(lease if self.known.get(node) == lease else 0, unheard=[MISSED])

    async def give_node(self, node: str, lease: int, snapshot: NodeSnapshot | None = None, failure: str = "") -> None:
        if not self.reachable:
            raise Unavailable("the link is down")
        self.calls.append((node, lease, snapshot, failure))


@pytest.fixture
def monitor() -> FakeMonitor:
    return FakeMonitor()


@pytest.fixture
def leases(monitor: Any) -> NodeLeases:
    return NodeLeases(monitor)


async def test_a_node_is_synchronized_when_its_lease_was_renewed(leases: NodeLeases) -> None:
    assert (await leases.take("amcl")).state == "taken"
    assert ("amcl" in leases, "move_base" in leases, leases.nodes()) == (True, False, ("amcl",))
    assert leases.synchronized() == frozenset()
    assert await leases.renew("amcl", NodeReport("moved"), []) == [MISSED]
    assert leases.synchronized() == {"amcl"}
    await leases.take("amcl")
    assert leases.synchronized() == frozenset(), "a new lease begins anew"


async def test_a_renewal_has_the_state_of_the_node_or_its_last_one(leases: NodeLeases, monitor: FakeMonitor) -> None:
    await leases.take("amcl")
    await leases.renew("amcl", None, ["a"])
    await leases.renew("amcl", NodeReport("moved", 0.1), ["a", "b"])
    await leases.renew("amcl", None, [])
    assert monitor.calls == [
        ("amcl", 1, "taken", 0.0, ["a"]),
        ("amcl", 1, "moved", 0.1, ["a", "b"]),
        ("amcl", 1, "moved", 0.0, []),
    ]


async def test_a_lease_that_the_node_monitor_does_not_know_is_not_renewed(
    leases: NodeLeases, monitor: FakeMonitor
) -> None:
    await leases.take("amcl")
    monitor.known.clear()
    assert await leases.renew("amcl", NodeReport("moved"), []) is None
    assert leases.synchronized() == frozenset()
    assert "amcl" in leases, "the caller decides whether to drop it"


async def test_a_node_is_given_back_with_its_last_state(leases: NodeLeases, monitor: FakeMonitor) -> None:
    await leases.take("amcl")
    leases.note("amcl", NodeSnapshot("removed", ["a"]))
    lease = leases.drop("amcl")
    assert "amcl" not in leases
    assert monitor.calls == []
    await leases.give_back("amcl", lease)
    assert monitor.calls == [("amcl", 1, NodeSnapshot("removed", ["a"]), "")]


async def test_a_node_that_cannot_run_is_refused_without_a_lease(leases: NodeLeases, monitor: FakeMonitor) -> None:
    await leases.refuse("amcl", "no map")
    assert monitor.calls == [("amcl", 0, None, "no map")]


async def test_lost_nodes_are_reported_once_as_soon_as_the_node_monitor_is_reachable(
    leases: NodeLeases, monitor: FakeMonitor
) -> None:
    await leases.take("amcl")
    await leases.take("move_base")
    leases.note("amcl", NodeSnapshot("moved", ["a"]))
    assert leases.lose("it was killed") == ("amcl", "move_base")
    assert leases.nodes() == ()
    monitor.reachable = False
    with pytest.raises(Unavailable):
        await leases.report_lost()
    monitor.reachable = True
    for _ in range(2):
        await leases.report_lost()
    assert monitor.calls == [
        ("amcl", 1, NodeSnapshot("moved", ["a"]), "it was killed"),
        ("move_base", 2, NodeSnapshot("taken"), "it was killed"),
    ]


async def test_changes_of_a_log_are_reported_until_they_arrive(leases: NodeLeases, monitor: FakeMonitor) -> None:
    reported: list[tuple[list[tuple[int, bytes]], list[int]]] = []
    hold_node, reachable = monitor.hold_node, False

    async def hold(node: str, lease: int, state: NodeReport, heard: list[str]) -> HoldNodeResponse:
        reported.append((state.log, state.obsolete))
        if not reachable:
            raise Unavailable("the link is down")
        return await hold_node(node, lease, state, heard)

    monitor.hold_node = hold  # type: ignore[method-assign]
    await leases.take("grid_slam")
    with pytest.raises(Unavailable):
        await leases.renew("grid_slam", NodeReport("1", log=[(0, b"a"), (1, b"b")]), [])
    reachable = True
    await leases.renew("grid_slam", NodeReport("2", log=[(2, b"c")], obsolete=[0]), [])
    await leases.renew("grid_slam", None, [])
    assert reported == [([(0, b"a"), (1, b"b")], []), ([(1, b"b"), (2, b"c")], [0]), ([], [])]
    leases.note("grid_slam", NodeSnapshot("3", [], LogChange([LogEntry(3, b"d")], [])))
    await leases.give_back("grid_slam", leases.drop("grid_slam"))
    assert monitor.calls[-1][2] == NodeSnapshot("3", [], LogChange([LogEntry(3, b"d")], []))


async def test_changes_of_all_logs_are_kept_if_the_renewal_of_another_node_fails(
    leases: NodeLeases, monitor: FakeMonitor
) -> None:
    await leases.take("amcl")
    await leases.take("grid_slam")
    change = LogChange([LogEntry(0, b"a")], [])
    states = leases.collect({"grid_slam": NodeReport("1", log=[(0, b"a")]), "amcl": NodeReport("2")})
    assert states == {"grid_slam": NodeReport("1"), "amcl": NodeReport("2")}
    # The renewal of amcl fails here, and the executor reports no change in its next states.
    leases.collect({"grid_slam": NodeReport("3"), "amcl": NodeReport("4")})
    await leases.give_back("grid_slam", leases.drop("grid_slam"))
    assert monitor.calls == [("grid_slam", 2, NodeSnapshot("taken", [], change), "")]
