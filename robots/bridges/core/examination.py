"""Examination of the robot's graph once a second: the log and ``ppaas doctor`` name its faults.

Findings are published on ``diagnostics``, which the doctor repeats for some seconds after each message.
"""

import asyncio
from collections.abc import Awaitable, Callable, Sequence

from ppaas.wire.ros.types import to_json
from robots.bridges.core.findings import WARN, Finding
from robots.bridges.core.parts import Parts

MISSING_AFTER = 5.0
"""Time that a robot has to show its topics before it is examined [s]."""

PERIOD = 1.0
"""Time between two examinations [s]."""

RECENT = 5.0
"""Time for which a warning about a single event is repeated [s]."""

MOST = 32
"""Largest number of findings that are published."""

TOPIC = "diagnostics"
NAME = "bridge"


class Examination:
    """Logs and publishes the faults of the robot's graph.

    Parameters
    ----------
    parts : Parts
        Ends of the bridge.
    look : callable
        Returns the faults that are there now.
    """

    def __init__(self, parts: Parts, look: Callable[[], Awaitable[Sequence[Finding]]]) -> None:
        self._parts, self._look = parts, look
        self._published: dict[str, Finding] = {}

    async def run(self) -> None:
        """Examine until cancelled."""
        await asyncio.sleep(MISSING_AFTER)
        while True:
            found = await self._look()
            for finding in found:
                self._parts.notices.tell(finding.text)
            self._publish([*found, *self._warnings()][:MOST])
            await asyncio.sleep(PERIOD)

    def _warnings(self) -> list[Finding]:
        texts = self._parts.notices.recent(self._parts.clock() - RECENT)
        return [Finding(f"warning {number}", text) for number, text in enumerate(texts, 1)]

    def _publish(self, found: Sequence[Finding]) -> None:
        """Publish findings, and once more those that are gone, as healthy."""
        now: dict[str, Finding] = {}
        for finding in found:
            before = now.get(finding.subject)
            text = f"{before.text}; {finding.text}" if before else finding.text
            now[finding.subject] = Finding(finding.subject, text, max(finding.level, before.level if before else WARN))
        gone = [Finding(subject, "", 0) for subject in self._published.keys() - now.keys()]
        self._published = now
        if statuses := [*now.values(), *gone]:
            array = [{"level": one.level, "name": f"{NAME}: {one.subject}", "message": one.text} for one in statuses]
            self._parts.link.publish_newest(TOPIC, to_json({"status": array}))
