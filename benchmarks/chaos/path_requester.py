"""Client that requests paths by REST, so that containers without a robot run too."""

import asyncio
import itertools
from collections import Counter
from collections.abc import Sequence

from ppaas.errors import PPaaSError
from robots.client.rest import RestClient
from robots.sim.courses import Course

PERIOD = 1.0
"""Period of the requests [s]."""


class PathRequester:
    """Requests paths, and counts the answers: a path, or the code of the error.

    Parameters
    ----------
    rest : RestClient
        Logged in.
    map_id : str
        Id of the map.
    courses : sequence of Course
        Starts and goals of the requested paths.
    """

    def __init__(self, rest: RestClient, map_id: str, courses: Sequence[Course]) -> None:
        self._rest = rest
        self._map = map_id
        self._ways = itertools.cycle([(course.start, goal) for course in courses for goal in course.goals])
        self.answers: Counter[str] = Counter()

    async def run(self) -> None:
        """Request paths until cancelled."""
        for start, goal in self._ways:
            try:
                await self._rest.plan(self._map, start, goal)
                self.answers["path"] += 1
            except PPaaSError as error:
                self.answers[error.slug] += 1
            await asyncio.sleep(PERIOD)
