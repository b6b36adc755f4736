"""Rules on a cloud: what would stop a robot from connecting to it."""

from collections.abc import Iterator

from ppaas.diagnosis.observations.cloud import CloudFacts
from ppaas.diagnosis.rules.finding import LEVELS, Finding, capital, error, names, ok, seconds, warn

SLOW = 0.25
"""Time of a request from which the link is too slow to drive over [s]."""

APART = 1.0
"""Difference between the clocks from which it matters [s]."""

SMALLEST = 0.1
"""Free capacity below which a machine counts as full [cores]."""


def cloud(facts: CloudFacts) -> list[Finding]:
    """Return what is right and wrong with a cloud, the worst first; one that is unreachable has one finding."""
    if facts.problem:
        text = f"The cloud at {facts.url} does not answer: {facts.problem.rstrip('.')}."
        advice = "Start it with 'ppaas up', or name its address with --url or PPAAS_URL; look at firewalls and proxies."
        return [error("cloud-unreachable", text, advice)]
    found = [*_link(facts), *_token(facts), *_stores(facts), *_machines(facts), *_robots(facts)]
    return sorted(found, key=lambda finding: -LEVELS.index(finding.level))


def _link(facts: CloudFacts) -> Iterator[Finding]:
    took = f"{facts.round_trip * 1e3:.0f} ms"
    if facts.round_trip > SLOW:
        text = f"A request to {facts.url} takes {took}: a robot here reacts late."
        yield warn("link-slow", text, "Use a cloud that is nearer, or a better link.")
    else:
        yield ok("cloud-reachable", f"The cloud at {facts.url} answers in {took}.")
    if facts.version != facts.own_version:
        text = f"The cloud has version {facts.version or 'unknown'} of ppaas, and this computer {facts.own_version}."
        yield warn("versions-differ", text, "Install the same version on both.")
    if abs(facts.ahead) > max(APART, facts.round_trip):
        side = "ahead of" if facts.ahead > 0 else "behind"
        text = f"The clock of this computer is {seconds(abs(facts.ahead))} {side} the cloud's."
        advice = "Install NTP on both (apt install chrony): stamps of scans and goals are compared with the clock."
        yield warn("clock-skew", text, advice)


def _token(facts: CloudFacts) -> Iterator[Finding]:
    if facts.token_problem:
        text = capital(f"the token is of no use: {facts.token_problem}")
        yield error("token", text, "Log in: export PPAAS_TOKEN=$(ppaas login USER).")
    elif facts.user:
        yield ok("token", f"The token is that of user '{facts.user}'.")


def _stores(facts: CloudFacts) -> Iterator[Finding]:
    for name, reason in facts.away.items():
        text = capital(f"the {name} of the cloud does not answer{': ' if reason else ''}{reason}")
        yield error("store-away", text, "Robots drive on, but none can connect anew: start the store.")
    if facts.disk != "ok":
        yield error("disk", capital(f"the disk of the cloud: {facts.disk}"), "Make space; nothing new is stored.")
    if facts.plans_waiting:
        text = f"{facts.plans_waiting} plans wait for their store."
        yield warn("plans-waiting", text, "They are kept on the disk, and stored once the store answers.")


def _machines(facts: CloudFacts) -> Iterator[Finding]:
    if facts.machines is None:
        return
    ready = [each for each in facts.machines if each.state == "ready"]
    if not ready:
        text = f"No machine accepts containers; there are {len(facts.machines)} that drain or are drained."
        yield error("no-machine", text, "Start one: 'ppaas up' or 'ppaas machine join'.")
        return
    free = {each.name: each.capacity - each.given for each in ready}
    largest = max(free, key=free.__getitem__)
    if free[largest] < SMALLEST:
        text = f"No machine has free cores: {names(free)} are full."
        yield error("no-capacity", text, "Add one (ppaas machine join), or disconnect robots.")
    else:
        text = f"Machines that accept containers: {len(ready)}; '{largest}' has {free[largest]:.1f} cores free."
        yield ok("machines", text)


def _robots(facts: CloudFacts) -> Iterator[Finding]:
    if facts.user and not facts.robots:
        yield warn("no-robots", "You have no robots.", "Register one: ppaas robot put ID FILE.json.")
    for robot in facts.robots:
        text = f"Robot '{robot.name}': {robot.text}"
        make = {"error": error, "warn": warn}.get(robot.level, ok)
        yield make("robot", text, f"See 'ppaas doctor {robot.name}'." if robot.level != "ok" else "")
