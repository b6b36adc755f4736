"""Reading Ray's table of nodes."""

from typing import Any

from ray.autoscaler.v2.schema import NodeInfo, NodeUsage, ResourceUsage

from engine.remote.ray.supervisor import ClusterNode, free_cores, machine_labels, read_nodes
from engine.specs.machine_settings import MOST_LABELS


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
