"""Watch of the traffic of a map: errors about its robots say who drives and who waits for whom."""

import asyncio
import logging
from collections.abc import Callable
from typing import Any

from ppaas.clock import monotonic
from ppaas.errors import PPaaSError
from robots.client.rest import RestClient
from robots.client.rest_paths import path_of

logger = logging.getLogger(__name__)

PERIOD = 2.0
"""Period at which the cloud is asked [s]."""


class TrafficWatch:
    """Asks the cloud for the traffic of a map, and adds its last answer to errors.

    Parameters
    ----------
    rest : RestClient
        Login of the owner of the robots.
    map_id : str
        Id of the map.
    tell : callable
        Called with a description of each error.
    """

    def __init__(self, rest: RestClient, map_id: str, tell: Callable[[str], None]) -> None:
        self._rest = rest
        self._path = path_of("maps", map_id, "traffic")
        self._tell = tell
        self._seen = "not known"
        self._seen_at = monotonic()

    def tell(self, what: str) -> None:
        """Tell an error, with the traffic as it was last seen."""
        self._tell(f"{what}; traffic {monotonic() - self._seen_at:.0f} s before: {self._seen}")

    async def run(self) -> None:
        """Ask until cancelled; while the cloud does not answer, the last answer is kept."""
        while True:
            try:
                self._see(await self._rest.get(self._path))
            except PPaaSError as error:
                logger.info("no answer about the traffic: %s", error)
            await asyncio.sleep(PERIOD)

    def _see(self, traffic: Any) -> None:
        self._seen = ", ".join(map(_in_words, traffic["robots"]))
        self._seen_at = monotonic()


def _in_words(robot: dict[str, Any]) -> str:
    x, y, _ = robot["pose"]
    waits = f" for {robot['waits_for']} since {robot['waited']:.0f} s" if robot["waits_for"] else ""
    return f"{robot['robot']} {robot['state']}{waits} at {x:.2f}, {y:.2f}"
