"""Rules on frames and stamps: unknown frames, several parents, loops; clocks that differ, stamps that run back."""

from collections.abc import Iterator

from ppaas.diagnosis.observations.facts import FrameFacts, Observations, TopicFacts
from ppaas.diagnosis.rules.finding import Finding, count, error, names, nearest, ok, percent, seconds, warn
from ppaas.nodes import topics
from ppaas.nodes.frames import MAP, SCAN_ODOM, prefixed

# -- rules on frames ---------------------------------------------------------------------------------------------------


def frames(seen: Observations) -> Iterator[Finding]:
    """Yield what is wrong with the frames of the robot."""
    parents = {frame.name: frame.parents[-1] for frame in seen.frames if frame.parents}
    loop = _loop(parents)
    if loop:
        text = f"Transforms close a loop: {' → '.join(loop)}."
        yield error("frames-loop", text, "Each frame has one parent, up to 'map': turn one transform round.", "tf")
    for frame in seen.frames:
        yield from _one(frame)
    for scan in seen.scans:
        yield from _laser(seen, parents, scan.frame)
    yield from _odometry(seen, parents)


def _one(frame: FrameFacts) -> Iterator[Finding]:
    if frame.alternates:
        text = f"Two programs publish the transform of '{frame.name}': it jumps to and fro."
        advice = "Stop one of them: for example publish_tf of the base if an EKF publishes it, or amcl on the robot."
        yield error("frames-two-senders", text, advice, "tf")
    elif len(set(frame.parents) - {SCAN_ODOM}) > 1:  # odometry may have come since
        text = f"Frame '{frame.name}' was given several parents: {names(frame.parents)}."
        yield error("frames-two-parents", text, "Let one program publish it, below one parent.", "tf")


def _laser(seen: Observations, parents: dict[str, str], name: str) -> Iterator[Finding]:
    frame = prefixed(seen.prefix, name) if prefixed(seen.prefix, name) in parents else name
    if not frame or frame == seen.base or _root(parents, frame) == _root(parents, seen.base):
        return
    known = sorted({*parents, *parents.values()})
    if frame in known:
        text = f"The frame of the laser, '{name}', is not connected with '{seen.base}'."
        advice = f"Publish the transform '{seen.base}' → '{_root(parents, frame)}' once on 'tf_static'."
        yield error("frames-laser-apart", f"{text} Its scans are not used.", advice, topics.SCAN.name)
        return
    text = f"The frame of the laser, '{name}', has no transform to '{seen.base}': its scans are not used."
    alike = nearest(name, known)
    hint = f" Did you mean '{alike}'?" if alike else ""
    advice = (
        f"Frames that exist: {names(known)}.{hint} Publish '{seen.base}' → '{name}' once on 'tf_static', upload a URDF "
        "that has this link, or send scans with a frame that exists."
    )
    yield error("frames-laser-unknown", text, advice, topics.SCAN.name)


def _odometry(seen: Observations, parents: dict[str, str]) -> Iterator[Finding]:
    child, parent = seen.motion.child, seen.motion.parent
    if not child:
        return
    if _root(parents, child) != _root(parents, seen.base) and child != seen.base:
        text = f"Odometry moves the frame '{child}' (child_frame_id), which is not connected with '{seen.base}'."
        advice = (
            f"Send child_frame_id '{seen.base}', or publish the transform between '{child}' and '{seen.base}' on "
            "'tf_static', or set base_frame_id of amcl in the robot file."
        )
        yield error("frames-odom-child", text, advice, topics.ODOM.name)
    if parent in (seen.base, child):
        text = f"Odometry has the frame '{parent}' as header.frame_id, which is the robot itself."
        yield error("frames-odom-parent", text, "header.frame_id is the fixed frame: send 'odom'.", topics.ODOM.name)
    elif parent == MAP:
        text = "Odometry has 'map' as header.frame_id: that frame belongs to localization."
        yield error("frames-odom-parent", text, "Send 'odom' as header.frame_id.", topics.ODOM.name)


def _root(parents: dict[str, str], frame: str) -> str:
    """Return the highest frame above a frame, or where a loop closes."""
    seen = [frame]
    while (above := parents.get(seen[-1])) is not None and above not in seen:
        seen.append(above)
    return seen[-1]


def _loop(parents: dict[str, str]) -> list[str]:
    """Return the frames of a loop, the first one again at its end; empty if there is none."""
    for start in parents:
        chain = [start]
        while (above := parents.get(chain[-1])) is not None:
            if above in chain:
                return [*chain[chain.index(above) :], above]
            chain.append(above)
    return []


# -- rules on stamps ---------------------------------------------------------------------------------------------------

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
