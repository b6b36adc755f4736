"""Somebody who asks for one path after another by REST, so that containers plan that are nobody's clones."""

import asyncio
import itertools
from collections import Counter
from collections.abc import Sequence

from ppaas.errors import PPaaSError
from robots.client.rest import RestClient
from robots.sim.courses import Course

PERIOD = 1.0
"""Seconds between two requests."""


class PathRequester:
    """Asks, and counts how it was answered: with a path, or with what kept the cloud from it.

    Parameters
    ----------
    rest : RestClient
        Logged in.
    map_id : str
        Of the map.
    courses : sequence of Course
        Between whose places paths are asked for.
    """

    def __init__(self, rest: RestClient, map_id: str, courses: Sequence[Course]) -> None:
        self._rest = rest
        self._map = map_id
        self._ways = itertools.cycle([(course.start, goal) for course in courses for goal in course.goals])
        self.answers: Counter[str] = Counter()

    async def run(self) -> None:
        """Ask until cancelled."""
        for start, goal in self._ways:
            try:
                await self._rest.plan(self._map, start, goal)
                self.answers["path"] += 1
            except PPaaSError as error:
                self.answers[error.slug] += 1
            await asyncio.sleep(PERIOD)
