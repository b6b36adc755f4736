"""Jobs of ``grid_slam`` that search for loop closures and thin the pose graph, one after the other."""

import logging
from collections.abc import Callable
from functools import partial

from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.mapping.live.closing_work import Closed
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.live.thinning_work import ThinnedMap
from ppaas.nodes.base import Context
from ppaas.nodes.jobs import LongWork

logger = logging.getLogger(__name__)


class ClosureJobs:
    """Does the work of a mapper in jobs, searches and thinnings, and applies the results: no scan waits for it.

    Parameters
    ----------
    context : Context
        Of the node.
    current : callable
        Returns the mapper whose closures are searched for; what was found for another one is dropped.
    on_moved : callable
        Called with the motion of the robot's pose in the map frame, when closures have moved the key frames.
    """

    def __init__(
        self, context: Context, current: Callable[[], LiveMapper | None], on_moved: Callable[[Pose2D], None]
    ) -> None:
        self._context, self._current, self._on_moved = context, current, on_moved

    def start(self) -> None:
        """Start the search that is due, if there is one and none is running."""
        mapper = self._current()
        if mapper is not None and (work := mapper.next_work()) is not None:
            self._context.start(LongWork(work), partial(self._on_closed, mapper))

    def _on_closed(self, mapper: LiveMapper, closed: Closed | ThinnedMap | PPaaSError | None) -> None:
        if mapper is not self._current():
            return  # the map was cleared meanwhile
        if isinstance(closed, PPaaSError):
            logger.warning("a search for loop closures or redundant key frames failed: %s", closed)
            closed = None
        motion = mapper.apply(closed)
        if motion is not None:
            self._on_moved(motion)
        self.start()
