"""Reading Ray's table of nodes."""

from typing import Any

from engine.remote.ray.nodes import ClusterNode, machine_labels, read_nodes
from engine.specs.machine_settings import MOST_LABELS


def row(node: str, cpu: float, *, alive: bool = True, **labels: str) -> dict[str, Any]:
    """Return a row of Ray's table."""
    resources = {"CPU": cpu, "memory": 8e9} if cpu else {"memory": 8e9}
    return {"NodeID": node, "Alive": alive, "NodeManagerAddress": "10.0.0.7", "Resources": resources, "Labels": labels}


def test_a_node_is_a_machine_with_the_labels_it_was_started_with():
    (node,) = read_nodes([row("a" * 56, 4.0, host="h3")], {"a" * 56: {"CPU": 2.5}})
    assert node == ClusterNode("a" * 56, "10.0.0.7", 4, 2, {"host": "h3"})
    assert node.machine == "a" * 10


def test_only_valid_labels_are_taken():
    given = {"ray.io/node-id": "a" * 56, "ray.io/accelerator-type": "A100", "host": "h3", "empty": "", "x" * 65: "long"}
    assert machine_labels(given) == {"host": "h3", "ray.io.accelerator-type": "A100"}
    assert len(machine_labels({f"k{number}": "v" for number in range(100)})) == MOST_LABELS


def test_dead_nodes_and_nodes_without_a_whole_core_are_not_machines():
    assert read_nodes([row("dead", 4.0, alive=False), row("head", 0.0), row("half", 0.5)], {}) == []


def test_a_node_without_free_cores_is_listed():
    (node,) = read_nodes([row("full", 4.0)], {"full": {"memory": 1.0}})
    assert (node.cores, node.free) == (4, 0)
