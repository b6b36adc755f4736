"""Refining mapper: a live mapper that aligns all its key frames with each other while the robot stands."""

from typing import Any

from ppaas.geometry import Pose2D
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.live.refining_work import RefinedMap, RefiningWork
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_log import GrowingMapping

MOST_REFINED = 4000
"""Largest number of key frames of a map that is refined; with 180 beams, this takes some 7 s of CPU time."""

LEAST_NEW, GROWTH = 16, 1.0 / 16.0
"""Number of key frames, and part of them, that are new when a map is refined again."""


class RefiningMapper(LiveMapper):
    """Live mapper that has work for idle times, besides the work of `next_work`.

    Parameters
    ----------
    *arguments, **options
        Of `LiveMapper`.

    Attributes
    ----------
    renewals : int
        Number of refinements, after each of which edges of the graph have other measurements.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.renewals = self._refined_to = 0

    def load(self, mapping: Mapping, start: Pose2D, *, keeps: bool = True) -> None:
        """Continue a mapping, or localize in it, as `LiveMapper.load` does. It was refined when it was published."""
        super().load(mapping, start, keeps=keeps)
        self._refined_to = len(self.key_frames)

    def next_idle_work(self) -> RefiningWork | None:
        """Return the refinement of the map if it is due; None while work is running, or where no loops are closed.

        Its result goes to `apply`. A robot that drives on may cancel it; then it stays due.
        """
        count = len(self.key_frames)
        if self._running is not None or not self._closes or not 1 < count <= MOST_REFINED:
            return None
        since = min(self._refined_to, count)  # key frames may have been removed
        if count - since < max(LEAST_NEW, int(GROWTH * since)):
            return None
        self._running = work = RefiningWork(
            self.mapping(""), self._submaps.finished[: self._searched], self._search, self._solver, self._drawing,
            self._canvas.extent, self.parts,
        )  # fmt: skip
        return work

    def give_up(self) -> None:
        """Refine the map only when it has grown: a refinement has failed."""
        self._refined_to = len(self.key_frames)

    def apply(self, result: Any) -> Pose2D | None:
        """Apply the result of work, as `LiveMapper.apply` does, or the result of `next_idle_work`."""
        if not isinstance(result, RefinedMap):
            return super().apply(result)
        self._running = None
        self.graph.renew_measurements(result.renewed, result.measurements)
        self.graph.add_edges(result.edges)
        self._waiting, self.closed = result.waiting, self.closed + result.closures
        self.renewals, self._refined_to = self.renewals + 1, len(result.poses)
        return self._move(result.poses, result.canvas, result.part)

    def growing(self) -> GrowingMapping:
        """Return what a log writer reads, as `LiveMapper.growing` does."""
        return super().growing()._replace(renewals=self.renewals)
