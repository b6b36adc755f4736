"""A Ray cluster whose nodes leave cleanly and leave nothing behind."""

import time

import psutil

from benchmarks.engine import ray_cluster
from engine.remote.ray import agent
from tests.support.cloud.cloud import named

END_TIMEOUT = 60.0

ATTENTIVE = {
    f"RAY_health_check_{name}": value
    for name, value in {
        "period_ms": "500", "timeout_ms": "10000", "failure_threshold": "3", "initial_delay_ms": "500",
    }.items()
}  # fmt: skip
"""A node that is dead refuses to be asked, and is told of after a second or two and not after fourteen. One that only
waits for a busy computer answers late, and has as long for it as Ray gives by itself."""


class RayNode(ray_cluster.LocalRayNode):
    """A node whose processes tests can find."""

    def find(self, *words: str) -> list[psutil.Process]:
        """Return the processes with all the words in their command line."""
        return named(self.family(), *words)

    def agent(self) -> psutil.Process:
        """Return the newest agent of its machine: one whose actor was killed may still be exiting."""
        return max(self.find(agent.__name__), key=lambda process: process.create_time())

    def raylet(self) -> psutil.Process:
        """Return the raylet; its children have the same command line for a moment."""
        return min(self.find("raylet/raylet", "--raylet_socket_name"), key=lambda process: process.create_time())

    def leave(self) -> None:
        """Leave the cluster like ``ray stop``, which ends every Ray process of its host."""
        family = self.family()
        raylet = self.raylet()
        raylet.terminate()
        psutil.wait_procs([raylet], END_TIMEOUT)
        self.process.terminate()
        self.process.wait(END_TIMEOUT)
        _, alive = psutil.wait_procs(family, END_TIMEOUT)
        assert not alive, f"left behind by node {self.address}: {alive}"


class RayCluster(ray_cluster.LocalRayCluster[RayNode]):
    """A cluster that checks at its end that nothing is left.

    Parameters
    ----------
    environment : str
        Variables of all its nodes, in addition to those of this process.
    """

    def __init__(self, **environment: str) -> None:
        super().__init__(RayNode, **ATTENTIVE, **environment)

    def _wait_until_clean(self) -> None:
        """Wait until the last agents have exited and left nothing."""
        deadline = time.monotonic() + END_TIMEOUT
        while left := sorted(path.name for path in self.runs.glob("ppaas-*")):
            assert time.monotonic() < deadline, f"left in the folder for temporary files: {left}"
            time.sleep(ray_cluster.BLINK)

    def stop(self) -> None:
        """End all nodes cleanly, the head last, and check that nothing is left."""
        try:
            for node in reversed(self.nodes):
                if node.process.poll() is None:
                    node.leave()
            self._wait_until_clean()
        finally:
            super().stop()
