"""Plan reuse of an executor: its stored plans, measured times and history, and processors that use them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ppaas.costmap.costmap import Costmap
from ppaas.plans.history import PlannerHistory
from ppaas.plans.reuse.processor import DEFAULTS, Note, PlanProcessor, ReuseParameters, ReuseScope
from ppaas.plans.reuse.time_estimates import Times
from ppaas.plans.stored import EmptyLibrary, PlanLibrary


def discard_note(row: PlannerHistory) -> None:
    """Discard a row: the note callback of an executor that stores no history."""


@dataclass(frozen=True, slots=True)
class ReuseSetup:
    """Stored plans, measured times and history of an executor.

    Parameters
    ----------
    map, version : str
        Map and its version.
    library : PlanLibrary
        Source of stored plans.
    times : Times
        Measured times.
    note : callable
        Called with a history row for each request.
    filters : mapping
        Masks that restrict the robot and other parameters of its costmap, by name.
    """

    map: str = ""
    version: str = ""
    library: PlanLibrary = field(default_factory=EmptyLibrary)
    times: Times = field(default_factory=Times)
    note: Note = discard_note
    filters: Mapping[str, Any] = field(default_factory=dict)

    def processor(
        self,
        bare: Costmap,
        robot_radius: float,
        parameters: ReuseParameters = DEFAULTS,
        *,
        filters: Mapping[str, Any] | None = None,
    ) -> PlanProcessor:
        """Return a processor for the costmap of the map alone and a robot radius [m]; ``filters`` add to its own."""
        scope = ReuseScope(self.map, self.version, bare, robot_radius, {**self.filters, **(filters or {})})
        return PlanProcessor(scope, self.library, self.times, self.note, parameters=parameters)
