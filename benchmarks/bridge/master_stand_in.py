"""Stand-in for a master of ROS 1, in threads and on the XML-RPC server of Python: independent of the bridge.

``python -m benchmarks.bridge.master_stand_in PORT`` runs one until it is terminated.
"""

import sys
import threading
import xmlrpc.client
from collections import defaultdict
from collections.abc import Callable
from socketserver import ThreadingMixIn
from typing import Any
from xmlrpc.server import SimpleXMLRPCServer

Registered = defaultdict[str, dict[str, str]]
"""URIs by names of nodes, by names of topics or services."""


class ThreadedServer(ThreadingMixIn, SimpleXMLRPCServer):
    """Server with a thread for each connection."""

    daemon_threads = True
    allow_reuse_address = True


class MasterStandIn:
    """Master on the loopback interface, which can be stopped and started anew, knowing nobody.

    Parameters
    ----------
    port : int
        Its port; 0 for a free one.

    Attributes
    ----------
    refused : set of str
        Topics whose next publisher is refused.
    """

    def __init__(self, port: int = 0) -> None:
        self.publishers: Registered = defaultdict(dict)
        self.subscribers: Registered = defaultdict(dict)
        self.services: Registered = defaultdict(dict)
        self.service_uris: dict[str, str] = {}
        self.types: dict[str, str] = {}
        self.nodes: dict[str, str] = {}
        self.refused: set[str] = set()
        self._server = ThreadedServer(("127.0.0.1", port), logRequests=False)
        for name, method in self._methods().items():
            self._server.register_function(method, name)
        self.port: int = self._server.server_address[1]
        self.uri = f"http://127.0.0.1:{self.port}"
        threading.Thread(target=self._server.serve_forever, args=(0.02,), daemon=True).start()

    def stop(self) -> None:
        """End the master."""
        self._server.shutdown()
        self._server.server_close()

    # -- methods -------------------------------------------------------------------------------------------------------

    def _methods(self) -> dict[str, Callable[..., Any]]:
        return {
            "registerPublisher": self._register_publisher,
            "unregisterPublisher": self._unregister_publisher,
            "registerSubscriber": self._register_subscriber,
            "unregisterSubscriber": self._unregister_subscriber,
            "registerService": self._register_service,
            "unregisterService": self._unregister_service,
            "getSystemState": self._get_system_state,
            "getTopicTypes": self._get_topic_types,
            "lookupService": self._lookup_service,
            "lookupNode": self._lookup_node,
        }

    def _node(self, node: str, uri: str) -> None:
        before = self.nodes.get(node)
        self.nodes[node] = uri
        if before not in (None, uri):
            self._tell(str(before), "shutdown", f"new node registered with same name {node}")

    def _register_publisher(self, node: str, topic: str, kind: str, uri: str) -> list[Any]:
        if topic in self.refused:
            self.refused.remove(topic)
            return [0, "refused", 0]
        self._node(node, uri)
        self.publishers[topic][node], self.types[topic] = uri, kind
        self._update(topic)
        return [1, "registered", list(self.subscribers[topic].values())]

    def _unregister_publisher(self, node: str, topic: str, uri: str) -> list[Any]:
        gone = self.publishers[topic].get(node) == uri and bool(self.publishers[topic].pop(node))
        self._update(topic)
        return [1, "unregistered", int(gone)]

    def _register_subscriber(self, node: str, topic: str, kind: str, uri: str) -> list[Any]:
        self._node(node, uri)
        self.subscribers[topic][node] = uri
        if self.types.get(topic, "*") == "*":
            self.types[topic] = kind
        return [1, "registered", list(self.publishers[topic].values())]

    def _unregister_subscriber(self, node: str, topic: str, uri: str) -> list[Any]:
        gone = self.subscribers[topic].get(node) == uri and bool(self.subscribers[topic].pop(node))
        return [1, "unregistered", int(gone)]

    def _register_service(self, node: str, service: str, data: str, uri: str) -> list[Any]:
        self._node(node, uri)
        self.services[service] = {node: uri}
        self.service_uris[service] = data
        return [1, "registered", 1]

    def _unregister_service(self, node: str, service: str, data: str) -> list[Any]:
        gone = self.service_uris.get(service) == data and bool(self.services.pop(service, {}).pop(node, ""))
        return [1, "unregistered", int(gone)]

    def _get_system_state(self, _node: str) -> list[Any]:
        tables = (self.publishers, self.subscribers, self.services)
        return [1, "state", [[[name, list(nodes)] for name, nodes in table.items() if nodes] for table in tables]]

    def _get_topic_types(self, _node: str) -> list[Any]:
        return [1, "types", [list(pair) for pair in self.types.items()]]

    def _lookup_service(self, _node: str, service: str) -> list[Any]:
        known = service in self.services
        return [1, "found", self.service_uris[service]] if known else [-1, f"unknown service {service}", ""]

    def _lookup_node(self, _node: str, node: str) -> list[Any]:
        return [1, "found", self.nodes[node]] if node in self.nodes else [-1, f"unknown node {node}", ""]

    # -- nodes ---------------------------------------------------------------------------------------------------------

    def _update(self, topic: str) -> None:
        uris = list(self.publishers[topic].values())
        for uri in self.subscribers[topic].values():
            self._tell(uri, "publisherUpdate", topic, uris)

    @staticmethod
    def _tell(uri: str, method: str, *arguments: Any) -> None:
        def tell() -> None:
            try:
                getattr(xmlrpc.client.ServerProxy(uri), method)("/master", *arguments)
            except OSError:
                return  # the node has gone, as nodes do

        threading.Thread(target=tell, daemon=True).start()


if __name__ == "__main__":
    MasterStandIn(int(sys.argv[1]))
    threading.Event().wait()
