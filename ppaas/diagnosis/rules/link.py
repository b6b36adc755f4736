"""Rules on the connection: of the robot, its topics, refusals and nodes, and of a robot that is absent."""

from collections.abc import Iterator

from ppaas.diagnosis.observations.facts import AbsenceFacts, LinkFacts, Observations
from ppaas.diagnosis.rules.finding import Finding, capital, count, error, names, ok, seconds, warn
from ppaas.nodes import topics

SLOW = 0.25
"""Round trip from which the robot reacts late [s]."""

REFUSED_SHARE = 0.5
"""Share of refused messages of a topic from which it counts as refused as a whole."""

AGV = ": AGV"
"""End of the name of the report of `ppaas bridge agv` on the AGV that the robot is, which is shown in any case."""

SENSORS = (topics.SCAN.name, topics.ODOM.name, topics.TF.name, topics.TF_STATIC.name)


def link(seen: Observations) -> Iterator[Finding]:
    """Yield what is wrong with the connection of the robot."""
    facts = seen.link
    if facts is None:
        return
    if facts.robots == 0:
        also = f", but {count(facts.operators, 'operator')}" if facts.operators else ""
        text = f"No robot is connected{also}."
        advice = "Connect with role=robot (the default): 'ws://HOST/?robot=ID'. An operator's scans are refused."
        yield error("robot-not-connected", text, advice)
        return
    yield from _quality(facts)
    yield from _elsewhere(facts)


def _quality(facts: LinkFacts) -> Iterator[Finding]:
    if facts.round_trip is not None and facts.round_trip > SLOW:
        text = f"A ping to the robot takes {facts.round_trip * 1e3:.0f} ms: it reacts late to obstacles."
        yield warn("link-slow", text, "Improve the radio link, or run Move Base on the robot (ppaas robot nodes).")
    if facts.dropped:
        text = f"The cloud dropped {count(facts.dropped, 'message')} to the robot, since it reads too slowly."
        yield warn("link-drops", text, "Read in a thread of its own, subscribe to less, or with a throttle_rate.")
    if facts.connects > 3:
        text = f"The robot connected {facts.connects} times in the last minutes."
        yield warn("link-reconnects", text, "Look at the radio, and at whether two programs connect as this robot.")


def _elsewhere(facts: LinkFacts) -> Iterator[Finding]:
    """Yield topics of clients that look like the clone's topics below a namespace."""
    for name in facts.client_topics:
        known = next((topic for topic in topics.TOPICS if name.endswith(f"/{topic}") and topic not in SENSORS[:2]), "")
        if known and "/" not in known:
            namespace = name.removesuffix(f"/{known}")
            text = f"The robot publishes '{name}', which the clone does not hear; it hears '{known}'."
            yield warn("topic-namespace", text, f"Add '&namespace={namespace}' to the address of the robot.", name)


def refusals(seen: Observations) -> Iterator[Finding]:
    """Yield the topics whose messages the clone or the cloud refuses, with the last reason."""
    for topic in seen.topics:
        if not topic.refused or (topic.name == topics.SCAN.name and _is_of_frames(seen, topic.refusal)):
            continue
        share = topic.refused / max(topic.rate * seen.seconds, topic.refused)
        make = error if share > REFUSED_SHARE and topic.name in SENSORS else warn
        came = count(topic.refused, "message")
        text = capital(f"{came} on '{topic.name}' refused while the robot was watched, the last one: {topic.refusal}")
        yield make("messages-refused", text, "Mend the message; the robot gets the same text as status.", topic.name)
    for name, reason in (seen.link.refused if seen.link is not None else {}).items():
        about = f"on '{name}' " if name else ""
        text = capital(f"the cloud refused an operation {about}of the robot: {reason}")
        yield warn("operation-refused", text, "Connect with '&status=1' to get all such errors.", name)


def _is_of_frames(seen: Observations, refusal: str) -> bool:
    """Return whether a scan was refused for its frame, which the rule on frames says with more words."""
    return refusal.startswith("unknown frame") and any(repr(scan.frame) in refusal for scan in seen.scans)


def nodes(seen: Observations) -> Iterator[Finding]:
    """Yield nodes that run, or should run, on the robot."""
    away = [node.name for node in seen.nodes if node.home == "robot"]
    if away:
        see = f"See 'ppaas robot nodes {seen.robot}'."
        yield ok("nodes-on-robot", f"Nodes that run on the robot: {names(away)}.", see)
    for node in seen.nodes:
        failed = next((reason for reason in node.reasons if "could not be run on the robot" in reason), "")
        if failed:
            text = capital(f"node '{node.name}' came back to the cloud: {failed}")
            yield warn(
                "node-failed", text, f"See 'ppaas robot nodes {seen.robot}', and the log of the robot's program."
            )
        elif node.wanted == "robot" and node.home == "cloud":
            text = f"Node '{node.name}' should run on the robot, which has not taken it."
            yield warn("node-not-taken", text, "Look whether the robot's local node manager runs.")


def reports(seen: Observations) -> Iterator[Finding]:
    """Yield what programs of the robot report on ``diagnostics``."""
    for report in seen.reports:
        if report.name.endswith(AGV):
            make = (ok, warn, error)[min(report.level, 2)]
            yield make("agv", f"AGV {report.name.removesuffix(AGV)}: {report.text}.", "", topics.DIAGNOSTICS.name)
            continue
        if report.level == 0:
            continue
        text = capital(f"the robot reports of {report.name}: {report.text or 'no text'}")
        make = error if report.level == 2 else warn
        yield make("robot-reports", text, "", topics.DIAGNOSTICS.name)


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
