"""Rules on stamps: clocks that differ, stamps that are missing or run backwards."""

from collections.abc import Iterator

from ppaas.diagnosis.observations.facts import Observations, TopicFacts
from ppaas.diagnosis.rules.finding import Finding, error, ok, warn
from ppaas.diagnosis.rules.words import count, percent, seconds
from ppaas.nodes import topics

LATE, EARLY = 1.0, 0.2
"""Delay and lead of a stamp from which the clocks differ, and not only the network is slow [s]."""

NOT_EPOCH = 365 * 86400.0
"""Delay from which stamps are not seconds since 1970 [s]."""

APART, REFUSED = 0.2, 1.0
"""Differences between the clocks of scans and odometry that blur the map, and with which scans are refused [s]."""

NTP = "Synchronise the robot's clock: install NTP (apt install chrony), or set the clock from the cloud's time."


def stamps(seen: Observations) -> Iterator[Finding]:
    """Yield what is wrong with the stamps of scans and odometry."""
    scan, odom = seen.topic(topics.SCAN.name), seen.topic(topics.ODOM.name)
    yield from _apart(scan, odom)
    yield from _clock(odom if odom.late is not None else scan)
    for facts in (scan, odom):
        yield from _own(facts)


def _apart(scan: TopicFacts, odom: TopicFacts) -> Iterator[Finding]:
    if scan.late is None or odom.late is None:
        return
    apart = scan.late - odom.late
    if abs(apart) <= APART:
        return
    side = "before" if apart > 0 else "ahead of"
    text = f"Scans are stamped {seconds(abs(apart))} {side} odometry of the same moment."
    advice = "Stamp both by one clock, with the time at which they were measured, not at which they were sent."
    if abs(apart) > REFUSED:
        yield error("scan-odom-clocks", f"{text} Such scans are not used.", advice, scan.name)
    else:
        yield warn("scan-odom-clocks", f"{text} Walls blur when the robot turns.", advice, scan.name)


def _clock(facts: TopicFacts) -> Iterator[Finding]:
    if facts.late is None or -EARLY <= facts.late <= LATE:
        return
    if abs(facts.late) > NOT_EPOCH:
        text = "Stamps are not seconds since 1970: they are those of a simulation, or of a computer without a clock."
        advice = f"{NTP} A robot without a clock may send stamps of zero, which mean the time of arrival."
        yield warn("stamps-not-epoch", text, advice, facts.name)
        return
    side = "behind" if facts.late > 0 else "ahead of"
    text = f"The robot's clock is {seconds(abs(facts.late))} {side} the cloud's, by the stamps of '{facts.name}'."
    yield warn("clock-skew", text, NTP, facts.name)


def _own(facts: TopicFacts) -> Iterator[Finding]:
    if facts.unstamped == 1.0:
        text = f"Stamps of '{facts.name}' are all zero, which means the time of arrival."
        advice = "Good enough for a slow robot; with real stamps the delay of the network does not matter."
        yield ok("stamps-zero", text, advice, facts.name)
    elif facts.unstamped > 0.0:
        text = f"{percent(facts.unstamped)} of the messages on '{facts.name}' have a stamp of zero, and the others not."
        yield warn("stamps-mixed", text, "Stamp all of them, or none.", facts.name)
    if facts.backwards:
        text = f"Stamps of '{facts.name}' ran backwards {count(facts.backwards, 'time')} while the robot was watched."
        advice = "Look for two publishers of the topic, or a clock that is set back (NTP that steps instead of slews)."
        yield warn("stamps-backwards", text, advice, facts.name)
