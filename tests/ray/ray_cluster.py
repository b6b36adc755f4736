"""A Ray cluster whose nodes leave in order, and leave nothing behind."""

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
    """A node of which tests find the processes."""

    def find(self, *words: str) -> list[psutil.Process]:
        """Return the processes with all the words in their command line."""
        return named(self.family(), *words)

    def agent(self) -> psutil.Process:
        """Return the agent of its machine; one whose actor was killed may be about to end."""
        return max(self.find(agent.__name__), key=lambda process: process.create_time())

    def raylet(self) -> psutil.Process:
        """Return what makes it a node; what it is about to start is called as it is for a moment."""
        return min(self.find("raylet/raylet", "--raylet_socket_name"), key=lambda process: process.create_time())

    def leave(self) -> None:
        """Have it leave its cluster, as ``ray stop`` does, which ends every process of Ray on its host."""
        family = self.family()
        raylet = self.raylet()
        raylet.terminate()
        psutil.wait_procs([raylet], END_TIMEOUT)
        self.process.terminate()
        self.process.wait(END_TIMEOUT)
        _, alive = psutil.wait_procs(family, END_TIMEOUT)
        assert not alive, f"left behind by node {self.address}: {alive}"


class RayCluster(ray_cluster.LocalRayCluster[RayNode]):
    """A cluster that looks at its end at whether something was left.

    Parameters
    ----------
    environment : str
        Variables of all its nodes, beside what this process has.
    """

    def __init__(self, **environment: str) -> None:
        super().__init__(RayNode, **ATTENTIVE, **environment)

    def _wait_until_clean(self) -> None:
        """Wait until the last agents have ended by themselves, and left nothing."""
        deadline = time.monotonic() + END_TIMEOUT
        while left := sorted(path.name for path in self.runs.glob("ppaas-*")):
            assert time.monotonic() < deadline, f"left in the folder for temporary files: {left}"
            time.sleep(ray_cluster.BLINK)

    def stop(self) -> None:
        """End all nodes in order, the head last, and look at whether something was left."""
        try:
            for node in reversed(self.nodes):
                if node.process.poll() is None:
                    node.leave()
            self._wait_until_clean()
        finally:
            super().stop()
