"""Jobs of ``grid_slam`` that search for loop closures, and thin and refine the map, one after the other."""

import logging
from collections.abc import Callable
from functools import partial
from typing import Any

from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.live.refining_mapper import RefiningMapper
from ppaas.mapping.live.refining_work import RefinedMap
from ppaas.nodes.base import Context, Job
from ppaas.nodes.jobs import LongWork

logger = logging.getLogger(__name__)

IDLE = 10.0
"""Time without a key frame after which the robot is taken to stand, and its map is refined [s]."""

PERIOD = 1.0
"""Time between two checks whether the robot stands [s]."""


class ClosureJobs:
    """Does the work of a mapper in jobs and applies the results: no scan waits for it.

    Searches and thinnings are done at once, and refinements while the robot stands; one is cancelled by a key frame.

    Parameters
    ----------
    context : Context
        Of the node.
    current : callable
        Returns the mapper whose closures are searched for; what was found for another one is dropped.
    on_moved : callable
        Called with the motion of the robot's pose in the map frame, when key frames have moved.
    """

    def __init__(
        self, context: Context, current: Callable[[], LiveMapper | None], on_moved: Callable[[Pose2D], None]
    ) -> None:
        self._context, self._current, self._on_moved = context, current, on_moved
        self._changed_at = 0.0
        self._refining: Job | None = None

    def watch(self) -> None:
        """Refine the map from now on when the robot stands."""
        self._changed_at = self._context.elapsed()
        self._context.every(PERIOD, self._refine)

    def start(self) -> None:
        """Start the search that is due after a key frame, if there is one and none is running."""
        self._changed_at = self._context.elapsed()
        if self._refining is not None:
            self._refining.cancel()  # without effect if it has ended
            self._refining = None
        self._start_due()

    def _start_due(self) -> None:
        mapper = self._current()
        if mapper is not None and (work := mapper.next_work()) is not None:
            self._context.start(LongWork(work), partial(self._on_closed, mapper))

    def _refine(self) -> None:
        """Start the refinement that is due if the robot stands, and nothing else is."""
        mapper = self._current()
        if not isinstance(mapper, RefiningMapper) or self._context.elapsed() - self._changed_at < IDLE:
            return
        self._start_due()
        if (work := mapper.next_idle_work()) is not None:
            self._refining = self._context.start(LongWork(work), partial(self._on_refined, mapper))

    def _on_refined(self, mapper: RefiningMapper, result: RefinedMap | PPaaSError | None) -> None:
        if isinstance(result, PPaaSError):
            mapper.give_up()
        self._on_closed(mapper, result)

    def _on_closed(self, mapper: LiveMapper, result: Any) -> None:
        if mapper is not self._current():
            return  # the map was cleared meanwhile
        if isinstance(result, PPaaSError):
            logger.warning("a search for loop closures or redundant key frames, or a refinement, failed: %s", result)
            result = None
        motion = mapper.apply(result)
        if motion is not None:
            self._on_moved(motion)
        self._start_due()
