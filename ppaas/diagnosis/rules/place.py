"""Rules on localization and on the robot's place on the map."""

from collections.abc import Iterator

from ppaas.diagnosis.observations.facts import Observations, PlaceFacts
from ppaas.diagnosis.rules.finding import Finding, capital, error, ok, percent, seconds, warn
from ppaas.diagnosis.rules.scans import BLIND
from ppaas.diagnosis.rules.sensors import SCANS_ALONE
from ppaas.nodes import topics

SILENT = 2.0
"""Time without an estimate from which localization has stopped [s]."""

OWN_SILENT = 5.0
"""Time without a pose of a robot that localizes itself after which Move Base stops it [s]."""

UNSURE, LOST = 0.5, 1.5
"""Standard deviations of the pose from which it is doubtful, and from which the robot is lost [m]."""

EXPLAINED, WRONG = 0.5, 0.25
"""Shares of the beams that end at walls of the map below which the pose is doubtful, and below which it is wrong."""

SET_POSE = "Set its pose: 'Set pose' in the dashboard, or a message on 'initialpose'; or call 'global_localization'."


def place(seen: Observations) -> Iterator[Finding]:
    """Yield what is wrong with the localization of the robot, and where it is."""
    facts, topic = seen.place, topics.GRID_SLAM_STATUS.name if seen.makes_map else topics.AMCL_STATUS.name
    if seen.follows_paths or seen.localizes_itself:
        yield from _own_place(facts)
        return
    if facts.problem and (_is_named(seen) or facts.problem == SCANS_ALONE):
        return
    if facts.problem and (seen.topic(topics.SCAN.name).refused or facts.problem.startswith(BLIND)):
        return  # the rules on frames, refusals and ranges say the same
    if facts.problem:
        text = capital(f"{'mapping' if seen.makes_map else 'localization'} uses no scans: {facts.problem}")
        yield error("localization-without-scans", text, "Mend what it names; other findings may say more.", topic)
        return
    if facts.pose is None or (facts.silence is not None and facts.silence > SILENT):
        yield from _without_pose(seen)
        return
    if seen.makes_map:
        yield ok("makes-map", "The robot makes a map while it drives; it needs no pose.", "", topics.MAP.name)
        return
    yield from _confidence(facts)
    yield from _on_map(facts)


def _own_place(facts: PlaceFacts) -> Iterator[Finding]:
    """Yield what is wrong with the place of a robot that localizes itself."""
    advice = "No goal starts from the pose before. Mend what it names; it continues by itself."
    if facts.problem:
        text = capital(f"the robot, which localizes itself, is not localized: {facts.problem}")
        yield error("not-localized", text, advice, topics.AMCL_STATUS.name)
    elif facts.pose is None or facts.silence is None or facts.silence > OWN_SILENT:
        since = "yet" if facts.silence is None else f"for {seconds(facts.silence)}"
        text = f"The robot localizes itself, and has published no pose {since}."
        yield error("not-localized", text, "Look at its program, such as 'ppaas bridge agv'.", topics.AMCL_POSE.name)
    else:
        yield from _confidence(facts)
        yield from _on_map(facts)


def _is_named(seen: Observations) -> bool:
    """Return whether scans or odometry are silent, which the rules on sensors say with more words."""
    silences = (seen.topic(name).silence for name in (topics.SCAN.name, topics.ODOM.name))
    return any(silence is not None and silence > SILENT for silence in silences)


def _without_pose(seen: Observations) -> Iterator[Finding]:
    scan, odom = seen.topic(topics.SCAN.name), seen.topic(topics.ODOM.name)
    if scan.silence is None or scan.silence > SILENT or odom.silence is None or odom.silence > SILENT:
        return  # the cause is reported already
    facts = seen.place
    since = "yet" if facts.silence is None else f"for {seconds(facts.silence)}"
    who = "grid_slam" if seen.makes_map else "amcl"
    text = f"Scans and odometry come, but {who} has not published a pose {since}."
    yield error("localization-silent", text, "See the findings on frames and stamps, and the refusals of 'scan'.", who)


def _confidence(facts: PlaceFacts) -> Iterator[Finding]:
    deviation = facts.deviation
    wrong = facts.explained is not None and facts.explained < WRONG
    if wrong or (deviation is not None and deviation > LOST):
        yield error("localization-lost", f"The robot is lost: {_why(facts)}.", SET_POSE, topics.AMCL_POSE.name)
    elif deviation is not None and deviation > UNSURE:
        text = f"Localization is unsure: the pose is known to {deviation:.1f} m."
        yield warn("localization-unsure", text, f"Drive a few metres. {SET_POSE}", topics.AMCL_POSE.name)
    elif facts.explained is not None and facts.explained < EXPLAINED:
        text = f"The map explains {percent(facts.explained)} of the last scan only."
        advice = f"The map is old, people stand around, or the pose is wrong. {SET_POSE}"
        yield warn("localization-fit", text, advice, topics.AMCL_POSE.name)


def _why(facts: PlaceFacts) -> str:
    if facts.explained is not None and facts.explained < WRONG:
        return f"the map explains {percent(facts.explained)} of its last scan"
    return f"its pose is known to {facts.deviation or 0.0:.1f} m"


def _on_map(facts: PlaceFacts) -> Iterator[Finding]:
    assert facts.pose is not None
    where = f"x {facts.pose[0]:.2f}, y {facts.pose[1]:.2f}"
    if facts.cell == "outside":
        text = f"By its pose ({where}) the robot is outside the map."
        yield error("pose-outside-map", text, f"Check initial_pose and origin of the map. {SET_POSE}", "amcl_pose")
    elif facts.cell == "occupied":
        text = f"By its pose ({where}) the robot is in an obstacle of the map."
        yield error("pose-in-obstacle", text, SET_POSE, "amcl_pose")
    elif facts.barrier:
        text = f"By its pose ({where}) the robot is in {facts.barrier}."
        advice = "With its next goal it leaves by the shortest way. If it belongs there, change the zone or mask."
        yield warn("pose-in-zone", text, advice, "amcl_pose")
    elif facts.cell == "unknown":
        text = f"By its pose ({where}) the robot is in unknown space of the map."
        yield warn("pose-in-unknown", text, f"Planners avoid it unless allow_unknown is set. {SET_POSE}", "amcl_pose")
    elif facts.clearance is not None and 0.0 < facts.clearance < facts.radius:
        text = (
            f"The footprint touches an obstacle of the map: it is {facts.clearance:.2f} m from the robot's centre, and "
            f"the robot's radius is {facts.radius:.2f} m."
        )
        advice = f"Move the robot away by hand, or check robot_radius and the footprint. {SET_POSE}"
        yield error("footprint-in-obstacle", text, advice, "amcl_pose")
