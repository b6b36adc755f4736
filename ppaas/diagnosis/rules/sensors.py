"""Rules on the arrival of scans and odometry: missing, stopped, too slow, in bursts, too large."""

from collections.abc import Iterator

from ppaas.diagnosis.observations.facts import Observations, TopicFacts
from ppaas.diagnosis.rules.finding import Finding, capital, error, hertz, names, percent, seconds, size, warn
from ppaas.nodes import topics

STOPPED = 1.0
"""Time without scans or odometry after which Move Base stops the robot [s]."""

SLOW = {topics.SCAN.name: 4.0, topics.ODOM.name: 8.0}
"""Rates below which a robot drives badly [Hz]."""

BURST = 0.3
"""Share of messages in bursts from which the link or the driver collects them."""

LARGE = 64e3
"""Size of a message from which a radio link has trouble with ten of them a second [bytes]."""

WIDE = 1e6
"""Data rate from which a radio link has trouble [bytes/s]."""

GROWTH = 0.3
"""Growth of the delay of messages from which the link cannot carry them [s]."""

SCANS_ALONE = (
    "no odometry comes: the map is made of scans alone, with steps of up to 0.25 m and 0.25 rad between two of them, "
    "and the robot is not driven; publish nav_msgs/Odometry on 'odom', or its transform on 'tf', to drive it"
)
"""Status of mapping while a robot has no odometry."""

TYPES = {topics.SCAN.name: "sensor_msgs/LaserScan", topics.ODOM.name: "nav_msgs/Odometry"}
HOW = {
    topics.SCAN.name: "Publish sensor_msgs/LaserScan on 'scan', 5 to 20 times a second.",
    topics.ODOM.name: "Publish nav_msgs/Odometry on 'odom', 10 to 50 times a second.",
}


def sensors(seen: Observations) -> Iterator[Finding]:
    """Yield what is wrong with the arrival of scans and odometry."""
    if seen.follows_paths:
        return  # it needs neither often: its pose is judged by the rules on its place
    for name in (topics.SCAN.name, topics.ODOM.name):
        facts = seen.topic(name)
        if name == topics.SCAN.name and seen.localizes_itself and facts.silence is None:
            continue  # it need not have a laser
        if facts.silence is None or facts.silence > STOPPED:
            yield from _silent(seen, facts)
            continue
        yield from _rate(seen, facts)
        yield from _volume(facts)


def _silent(seen: Observations, facts: TopicFacts) -> Iterator[Finding]:
    name = facts.name
    if name == topics.ODOM.name and seen.place.problem == SCANS_ALONE:
        text = "The robot makes its map without odometry: by scans alone, which fails in bare corridors and fast turns."
        yield error("maps-without-odometry", text, f"It is not driven. {HOW[name]}", name)
        return
    if name == topics.ODOM.name and _moves_by_tf(seen):
        text = "No odometry comes on 'odom', but tf moves the robot: Move Base does not know its velocity."
        yield warn("odom-by-tf-only", text, "Publish nav_msgs/Odometry on 'odom' too; its twist is used.", name)
        return
    if facts.refused:
        return  # the rule on refusals gives the reason
    what = "scan" if name == topics.SCAN.name else "odometry"
    if facts.silence is None:
        text = f"No {what} has come: the robot publishes nothing on '{name}'."
        yield error(f"{name}-missing", text, _how(seen, name), name)
        return
    text = f"The last {what} came {seconds(facts.silence)} ago; Move Base stops the robot after {STOPPED:g} s."
    advice = _elsewhere(seen, name) or f"Look at the program that publishes '{name}', and at the connection."
    yield error(f"{name}-stopped", text, advice, name)


def _moves_by_tf(seen: Observations) -> bool:
    """Return whether tf, without the map's frame, moves the robot's body."""
    frame = seen.frame(seen.base)
    return frame is not None and not frame.static and frame.silence <= STOPPED


def _how(seen: Observations, name: str) -> str:
    """Return how a topic comes to be published, with what is known of this robot."""
    if name == topics.SCAN.name and seen.camera:
        camera = seen.topic(topics.DEPTH_IMAGE.name)
        return (
            "The scans are made of depth images: publish 'camera/depth/image_raw' and 'camera/depth/camera_info'."
            if not camera.count
            else "Depth images come, but no scan is made of them: see the refusals of 'camera/depth/image_raw'."
        )
    return _elsewhere(seen, name) or HOW[name]


def _elsewhere(seen: Observations, name: str) -> str:
    """Return why the robot does not publish a topic as far as that is known: refused, or under another name."""
    if seen.link is None:
        return ""
    if reason := seen.link.refused.get(name):
        return capital(f"the cloud refused what came on it: {reason}")
    others = [topic for topic, kind in seen.link.client_topics.items() if kind == TYPES[name]]
    return _renamed(others, name) if others else ""


def _renamed(others: list[str], name: str) -> str:
    namespace = next((each.removesuffix(f"/{name}") for each in others if each.endswith(f"/{name}")), "")
    text = f"{TYPES[name]} comes on another topic, {names(map(repr, others))}, which the clone does not hear. "
    if namespace:
        return f"{text}Add '&namespace={namespace}' to the address of the robot, or publish on '{name}'."
    return f"{text}Publish it on '{name}'."


def _rate(seen: Observations, facts: TopicFacts) -> Iterator[Finding]:
    name, least = facts.name, SLOW[facts.name]
    if seen.seconds >= 2.0 and 0.0 < facts.rate < least:
        text = f"'{name}' comes at {hertz(facts.rate)} only: the robot drives well with {hertz(least)} or more."
        yield warn(f"{name}-slow", text, HOW[name], name)
    if facts.gap is not None and facts.gap > STOPPED:
        text = f"'{name}' paused for {seconds(facts.gap)}: Move Base stops the robot after {STOPPED:g} s without it."
        yield warn(f"{name}-gaps", text, "Look at the connection and at the load of the robot's computer.", name)
    elif facts.burst > BURST:
        text = f"{percent(facts.burst)} of the messages on '{name}' come in bursts, although they were taken evenly."
        advice = "Switch off the power saving of the radio (iw dev wlan0 set power_save off), or send with TCP_NODELAY."
        yield warn(f"{name}-bursts", text, advice, name)


def _volume(facts: TopicFacts) -> Iterator[Finding]:
    name = facts.name
    if facts.growth > GROWTH:
        text = (
            f"'{name}' comes later and later: the delay grew by {seconds(facts.growth)} while "
            f"{size(facts.bandwidth)}/s came. The connection carries less than the robot sends."
        )
        yield error(f"{name}-too-much", text, f"Send smaller messages or fewer: now {size(facts.size)} each.", name)
    elif facts.size > LARGE or facts.bandwidth > WIDE:
        text = f"A message on '{name}' takes {size(facts.size)}, in total {size(facts.bandwidth)}/s."
        advice = "Round ranges to millimetres, leave out intensities, or send fewer beams; 360 beams at 10 Hz suffice."
        yield warn(f"{name}-large", text, advice, name)
