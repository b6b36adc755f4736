"""Diagnosis: all rules, applied to the observations of a robot."""

from collections.abc import Callable, Iterator

from ppaas.diagnosis.observations.facts import Observations
from ppaas.diagnosis.rules.driving import goals, motion
from ppaas.diagnosis.rules.finding import LEVELS, Finding
from ppaas.diagnosis.rules.frames import frames, stamps
from ppaas.diagnosis.rules.link import link, nodes, refusals, reports
from ppaas.diagnosis.rules.place import place
from ppaas.diagnosis.rules.scans import scans
from ppaas.diagnosis.rules.sensors import sensors

RULES: tuple[Callable[[Observations], Iterator[Finding]], ...] = (
    link, sensors, frames, stamps, refusals, scans, place, goals, motion, nodes, reports,
)  # fmt: skip
"""All rules, in the order in which a robot is connected: what is wrong first is often the cause of the rest."""


def diagnose(seen: Observations) -> list[Finding]:
    """Return what is right and wrong with a robot, the worst first, and causes before their effects.

    Parameters
    ----------
    seen : Observations
        What was observed. Without a connected robot nothing else is judged: all of it is missing.
    """
    if seen.link is not None and seen.link.robots == 0:
        return list(link(seen))
    found = [finding for rule in RULES for finding in rule(seen)]
    return sorted(found, key=lambda finding: -LEVELS.index(finding.level))
