"""Options of the engine bench."""

from dataclasses import dataclass

from benchmarks.harness.figures import PartSelection

READY_LIMIT_MS = {"process": 100.0, "ray": 100.0, "docker": 400.0}
"""Time within which a container must be ready [ms], by runtime; on Ray after the first start of a node."""

PAUSES = {"docker": 5.0}
"""Pause between two robots that are opened [s], in which the runtime refills its reserve of containers."""

RUNTIMES = tuple(READY_LIMIT_MS)


@dataclass(frozen=True, slots=True)
class EngineOptions(PartSelection):
    """Options of the engine bench.

    Parameters
    ----------
    runtime : str
        Runtime of the containers, one of ``RUNTIMES``.
    containers : int
        Number of containers at once on one machine.
    placements, machines : int
        Number of containers that the master places, and of machines.
    """

    runtime: str = "process"
    containers: int = 100
    placements: int = 10_000
    machines: int = 1_000

    def of(self, many: int, few: int) -> int:
        """Return the number of samples: ``few`` in a quick run, else ``many``."""
        return few if self.quick else many
