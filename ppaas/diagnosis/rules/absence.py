"""Rules on a robot that is not connected."""

from collections.abc import Iterator

from ppaas.diagnosis.observations.absence import AbsenceFacts
from ppaas.diagnosis.rules.finding import Finding, error
from ppaas.diagnosis.rules.words import capital, seconds

ABSENT = "robot-not-connected"
"""Kind of the finding about every robot that is not connected."""


def absence(facts: AbsenceFacts) -> Iterator[Finding]:
    """Yield that a robot is not connected, and what would stop it from connecting."""
    if facts.refusal:
        text = capital(f"its last attempt to connect, {seconds(facts.refused_ago)} ago, was refused: {facts.refusal}")
        yield error("connect-refused", text, "Mend what it names; the robot's program gets the same text.")
    if facts.map_problem:
        text = capital(f"its map cannot be used: {facts.map_problem}")
        yield error("map-unusable", text, "Publish the map, or name another one: ppaas robot change ROBOT map=NAME.")
    if facts.quota_problem:
        text = capital(f"its user may have no more containers: {facts.quota_problem}")
        yield error("quota", text, "Disconnect another robot, or ask an administrator for more (ppaas user change).")
    yield from _capacity(facts)
    text = f"Robot '{facts.robot}' is not connected."
    advice = (
        f"Start its program: it opens 'ws://HOST/?robot={facts.robot}' with its token, and sends scans and odometry."
    )
    if facts.agv:
        text = f"Robot '{facts.robot}', which is AGV {facts.agv}, is not connected."
        advice = (
            "Look whether 'ppaas bridge agv' runs; its log names AGVs that have been offline for more than 60 s, that "
            "send no valid state with a position, or that are refused as this robot."
        )
    yield error(ABSENT, text, advice)


def _capacity(facts: AbsenceFacts) -> Iterator[Finding]:
    if not facts.free:
        text = "No machine accepts containers now."
        yield error("no-machine", text, "Start one: ppaas machine join; or end the drain: ppaas machine change.")
    elif max(facts.free) < facts.cores:
        text = f"Its container needs {facts.cores:g} cores, and no machine has more than {max(facts.free):g} free."
        advice = "Make it smaller (ppaas robot change ROBOT cores=0.5), disconnect robots, or add a machine."
        yield error("no-capacity", text, advice)
