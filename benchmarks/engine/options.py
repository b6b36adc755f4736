"""What is asked of the bench of the engine."""

from dataclasses import dataclass

from benchmarks.harness.parts import PartSelection

READY_LIMIT_MS = {"process": 100.0, "ray": 100.0, "docker": 400.0}
"""In which a container must be ready, by its runtime; on Ray beyond the first start of a node."""

PAUSES = {"docker": 5.0}
"""Seconds between two robots that are opened, where a runtime has containers in reserve and makes others meanwhile."""

RUNTIMES = tuple(READY_LIMIT_MS)


@dataclass(frozen=True, slots=True)
class EngineOptions(PartSelection):
    """What to measure.

    Parameters
    ----------
    runtime : str
        Starts the containers: one of ``RUNTIMES``.
    containers : int
        At a time on one machine.
    placements, machines : int
        That the master places, and on how many.
    """

    runtime: str = "process"
    containers: int = 100
    placements: int = 10_000
    machines: int = 1_000

    def of(self, many: int, few: int) -> int:
        """Return how many samples to take, by whether few will do."""
        return few if self.quick else many
