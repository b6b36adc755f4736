"""The nodes of a Ray cluster that can be machines."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from engine.specs.machine_settings import MOST_LABELS
from storage.names import is_name

NODE_LABEL = "ray.io/node-id"

MACHINE_NAME = 10
"""Number of characters of a node's id that name its machine; short, since names of sockets contain it."""


@dataclass(frozen=True, slots=True)
class ClusterNode:
    """A running node.

    Parameters
    ----------
    id : str
        Unique id; a host that joins again gets a new one.
    address : str
        Address of its host.
    cores : int
        Number of whole CPUs.
    labels : dict of str to str
        Labels that it was started with or got from Ray, as labels of a machine.
    """

    id: str
    address: str
    cores: int
    labels: dict[str, str] = field(default_factory=dict)

    @property
    def machine(self) -> str:
        """Name of its machine."""
        return self.id[:MACHINE_NAME]


def read_nodes(table: Iterable[Mapping[str, Any]]) -> list[ClusterNode]:
    """Return the nodes that can be machines: those that run and have at least one whole CPU.

    Parameters
    ----------
    table : iterable of mappings
        Result of ``ray.nodes()``, which contains dead nodes too.
    """
    nodes = []
    for row in table:
        cores = int(row["Resources"].get("CPU", 0.0))
        if row["Alive"] and cores >= 1:
            labels = machine_labels(row["Labels"])
            nodes.append(ClusterNode(row["NodeID"], row["NodeManagerAddress"], cores, labels))
    return nodes


class Usage(Protocol):
    """A node in Ray's status of a cluster."""

    @property
    def node_id(self) -> str | None:
        """Its id; None before it runs."""

    def available_resources(self) -> Mapping[str, float]:
        """Return the amount of each resource that no work of Ray holds."""


def free_cores(node: ClusterNode, status: Iterable[Usage]) -> int:
    """Return the number of whole CPUs of a node that no work of Ray holds; none of a node that the status lacks."""
    return sum(int(usage.available_resources().get("CPU", 0.0)) for usage in status if usage.node_id == node.id)


def machine_labels(labels: Mapping[str, str]) -> dict[str, str]:
    """Return the labels of a node that are valid for a machine, with ``.`` for ``/``, without the id's label.

    Labels of Ray may be empty, or as long as in Kubernetes. Labels that are not valid for a machine are omitted.
    """
    named = {key.replace("/", "."): value for key, value in labels.items() if key != NODE_LABEL}
    fitting = sorted((key, value) for key, value in named.items() if is_name(key) and is_name(value))
    return dict(fitting[:MOST_LABELS])
