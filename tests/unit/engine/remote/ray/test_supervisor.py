"""The table of Ray's nodes, and the supervisor on a cluster that the test controls."""

import logging
from collections.abc import Callable
from typing import Any

import pytest
from ray.autoscaler.v2.schema import NodeInfo, NodeUsage, ResourceUsage

from engine.remote.ray.supervisor import (
    END_TIMEOUT,
    RETRY_DELAYS,
    START_TIMEOUT,
    STEADY,
    ClusterNode,
    Supervisor,
    free_cores,
    machine_labels,
    read_nodes,
)
from engine.specs.machine_settings import MOST_LABELS


class FakeKeeper:
    """A fake keeper of an agent."""

    def __init__(self) -> None:
        self.up, self.reason = True, None
        self.calls: list[str] = []
        self.takes_to_end: Callable[[float], None] = lambda _: None

    def started(self) -> bool:
        return self.up

    def ended(self) -> str | None:
        return self.reason

    def kill_agent(self) -> None:
        self.calls.append("kill_agent")

    def end(self) -> None:
        self.calls.append("end")

    def join(self, timeout: float) -> None:
        self.calls.append("join")
        self.takes_to_end(timeout)

    def kill(self) -> None:
        self.calls.append("kill")


class FakeCluster:
    """A cluster whose nodes the test sets."""

    def __init__(self, *nodes: ClusterNode) -> None:
        self.there = list(nodes)
        self.free: dict[str, int] = {}
        self.known: dict[str, FakeKeeper] = {}
        self.kept: list[tuple[str, int, FakeKeeper]] = []
        self.up = True

    def nodes(self) -> list[ClusterNode]:
        return self.there

    def free_cores(self, node: ClusterNode) -> int:
        return self.free.get(node.id, node.cores)

    def find(self, node: ClusterNode) -> FakeKeeper | None:
        return self.known.get(node.id)

    def keep(self, node: ClusterNode, cores: int) -> FakeKeeper:
        keeper = FakeKeeper()
        keeper.up = self.up
        self.kept.append((node.id, cores, keeper))
        return keeper

    @property
    def begun(self) -> list[tuple[str, int]]:
        return [(node, cores) for node, cores, _ in self.kept]


class FakeClock:
    """A clock that the test sets."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def node(name: str) -> ClusterNode:
    return ClusterNode(name * 10, f"host-{name}", 4)


def test_each_node_gets_one_agent_with_the_cores_that_are_free():
    cluster = FakeCluster(node("a"), node("b"))
    cluster.free["b" * 10] = 3
    supervisor = Supervisor(cluster)
    supervisor.reconcile()
    cluster.there.append(node("c"))
    supervisor.reconcile()
    assert sorted(cluster.begun) == [("a" * 10, 4), ("b" * 10, 3), ("c" * 10, 4)]
    assert sorted(supervisor.machines) == ["a" * 10, "b" * 10, "c" * 10]


def test_no_more_cores_are_used_than_configured():
    cluster = FakeCluster(node("a"), node("b"))
    cluster.free["b" * 10] = 1
    Supervisor(cluster, cores=2).reconcile()
    assert sorted(cluster.begun) == [("a" * 10, 2), ("b" * 10, 1)]


def test_a_node_without_a_free_core_waits_and_is_logged_once(caplog: pytest.LogCaptureFixture):
    cluster = FakeCluster(node("a"))
    cluster.free["a" * 10] = 0
    supervisor = Supervisor(cluster)
    for _ in range(3):
        supervisor.reconcile()
    assert cluster.begun == []
    assert caplog.text.count("no free core") == 1
    cluster.free["a" * 10] = 2
    supervisor.reconcile()
    assert cluster.begun == [("a" * 10, 2)]


def test_existing_agent_is_adopted_although_it_holds_all_cores():
    cluster = FakeCluster(node("a"))
    cluster.free["a" * 10] = 0
    cluster.known["a" * 10] = FakeKeeper()
    supervisor = Supervisor(cluster)
    supervisor.reconcile()
    assert (cluster.begun, supervisor.machines) == ([], ["a" * 10])


def test_node_that_left_is_forgotten(caplog: pytest.LogCaptureFixture):
    cluster = FakeCluster(node("a"))
    supervisor = Supervisor(cluster)
    supervisor.reconcile()
    cluster.there = []
    supervisor.reconcile()
    assert supervisor.machines == []
    assert "left the cluster" in caplog.text
    cluster.there = [node("b")]
    supervisor.reconcile()
    assert supervisor.machines == ["b" * 10]


def test_an_agent_that_exits_is_restarted_with_growing_delays(caplog: pytest.LogCaptureFixture):
    clock, cluster = FakeClock(), FakeCluster(node("a"))
    supervisor = Supervisor(cluster, clock=clock)
    began = []
    for _ in range(400):
        count = len(cluster.kept)
        supervisor.reconcile()
        if len(cluster.kept) > count:
            began.append(clock.now)
            cluster.kept[-1][2].reason = "No module named 'engine'"
        clock.now += 0.125
    assert began[:5] == [0.0, 0.125, 1.25, 6.375, 21.5]
    assert "No module named 'engine'" in caplog.text


def test_an_agent_that_exits_after_a_steady_time_is_restarted_at_once():
    clock, cluster = FakeClock(), FakeCluster(node("a"))
    supervisor = Supervisor(cluster, clock=clock)
    for count in range(1, len(RETRY_DELAYS) + 3):
        supervisor.reconcile()
        assert len(cluster.kept) == count
        clock.now += STEADY + 1.0
        cluster.kept[-1][2].reason = "killed"
        supervisor.reconcile()


def test_an_agent_that_ray_does_not_start_is_given_up_and_retried():
    clock, cluster = FakeClock(), FakeCluster(node("a"))
    cluster.up = False
    supervisor = Supervisor(cluster, clock=clock)
    supervisor.reconcile()
    clock.now = START_TIMEOUT - 1.0
    supervisor.reconcile()
    assert cluster.kept[0][2].calls == []
    clock.now = START_TIMEOUT + 1.0
    supervisor.reconcile()
    assert cluster.kept[0][2].calls == ["kill"]
    supervisor.reconcile()
    assert len(cluster.kept) == 2


def test_frozen_agent_is_killed_on_its_machine_only():
    cluster = FakeCluster(node("a"), node("b"))
    supervisor = Supervisor(cluster)
    supervisor.reconcile()
    supervisor.kill_agent("b" * 10)
    supervisor.kill_agent("no such machine")
    assert {name: keeper.calls for name, _, keeper in cluster.kept} == {"a" * 10: [], "b" * 10: ["kill_agent"]}


def test_all_agents_are_stopped_before_waiting_for_the_first(caplog: pytest.LogCaptureFixture):
    caplog.set_level(logging.INFO)
    cluster = FakeCluster(node("a"), node("b"))
    supervisor = Supervisor(cluster)
    supervisor.reconcile()
    supervisor.end_all()
    assert [keeper.calls for _, _, keeper in cluster.kept] == [["end", "join"]] * 2
    assert supervisor.machines == []


def test_agents_that_do_not_end_by_themselves_are_waited_for_together():
    clock, cluster = FakeClock(), FakeCluster(node("a"), node("b"), node("c"))
    supervisor = Supervisor(cluster, clock=clock)
    supervisor.reconcile()

    def take_all(timeout: float) -> None:
        clock.now += timeout

    for _, _, keeper in cluster.kept:
        keeper.takes_to_end = take_all
    supervisor.end_all()
    assert clock.now == END_TIMEOUT


def row(node: str, cpu: float, *, alive: bool = True, **labels: str) -> dict[str, Any]:
    """Return a row of Ray's table."""
    resources = {"CPU": cpu, "memory": 8e9} if cpu else {"memory": 8e9}
    return {"NodeID": node, "Alive": alive, "NodeManagerAddress": "10.0.0.7", "Resources": resources, "Labels": labels}


def test_a_node_is_a_machine_with_the_labels_it_was_started_with():
    (node,) = read_nodes([row("a" * 56, 4.0, host="h3")])
    assert node == ClusterNode("a" * 56, "10.0.0.7", 4, {"host": "h3"})
    assert node.machine == "a" * 10


def test_only_valid_labels_are_taken():
    given = {"ray.io/node-id": "a" * 56, "ray.io/accelerator-type": "A100", "host": "h3", "empty": "", "x" * 65: "long"}
    assert machine_labels(given) == {"host": "h3", "ray.io.accelerator-type": "A100"}
    assert len(machine_labels({f"k{number}": "v" for number in range(100)})) == MOST_LABELS


def test_dead_nodes_and_nodes_without_a_whole_core_are_not_machines():
    assert read_nodes([row("dead", 4.0, alive=False), row("head", 0.0), row("half", 0.5)]) == []


def usage(node: str | None, **resources: tuple[float, float]) -> NodeInfo:
    """Return a node in Ray's status, with the total and the used amount of resources."""
    used = NodeUsage([ResourceUsage(name, *amounts) for name, amounts in resources.items()], idle_time_ms=0)
    return NodeInfo("", "", "", "10.0.0.7", "RUNNING", node, used)


def test_cores_are_free_that_no_work_of_ray_holds_as_a_whole():
    node = ClusterNode("a" * 56, "10.0.0.7", 4)
    assert free_cores(node, [usage("b" * 56, CPU=(8.0, 0.0)), usage("a" * 56, CPU=(4.0, 1.5), memory=(8e9, 0.0))]) == 2
    assert free_cores(node, [usage("a" * 56, CPU=(4.0, 4.0))]) == 0


def test_a_node_that_the_status_lacks_has_no_free_cores_yet():
    status = [
        usage(None, CPU=(4.0, 0.0)),
        usage("a" * 56, memory=(8e9, 0.0)),
        NodeInfo("", "", "", "", node_id="a" * 56),
    ]
    assert free_cores(ClusterNode("a" * 56, "10.0.0.7", 4), status) == 0
