"""Examination of a cloud, its robots and this computer's packages for ``ppaas doctor``, and its view as text."""

import asyncio
import textwrap
from collections import Counter
from importlib.util import find_spec
from typing import Any

import msgspec

from ppaas import __version__
from ppaas.clock import epoch, monotonic
from ppaas.diagnosis.observations.cloud import CloudFacts, MachineFacts, RobotLine
from ppaas.diagnosis.rules.cloud import cloud
from ppaas.diagnosis.rules.finding import Finding, error, hertz, names, nearest, seconds, size, worst
from ppaas.distribution import BASE, misfits, pip_command
from ppaas.errors import NotAuthenticated, NotFound, NotPermitted, PPaaSError
from robots.cli.output import printable, table
from robots.client.cloud_url import path_of
from robots.client.rest import RestClient

MOST_AT_ONCE = 8
"""Largest number of robots that are examined at once."""

TIMEOUT = 20.0
"""Time limit of a request [s]."""

STORES = {"store": "store", "map_store": "map store", "audit": "audit log"}
"""Members of the cloud's health that have a state, and their names in words."""


class Examination:
    """Examines a cloud with the token of a user.

    Parameters
    ----------
    url : str
        URL of the cloud.
    token : str or None
        Token of the user.
    seconds : float
        Time for which each robot is watched [s].
    """

    def __init__(self, url: str, token: str | None, seconds: float) -> None:
        self._url, self._token, self._seconds = url, token, seconds
        self._client = RestClient(url, token, TIMEOUT)

    async def robot(self, robot: str) -> dict[str, Any]:
        """Return the diagnosis of a robot; the cloud's if the cloud is in trouble."""
        facts = await self._reach()
        if facts.problem or facts.token_problem:
            return _report(facts, cloud(facts))
        try:
            return await self._diagnosis(robot)
        except NotFound as missing:
            known = [each["id"] for each in await self._client.items(path_of("robots"))]
            return _report(facts, [_unknown(robot, known, str(missing))])

    async def cloud(self) -> dict[str, Any]:
        """Return the diagnosis of the cloud, with a line for each robot of the user."""
        facts = await self._reach()
        if facts.user:
            machines, robots = await asyncio.gather(self._machines(), self._robots())
            facts = msgspec.structs.replace(facts, machines=machines, robots=robots)
        return _report(facts, cloud(facts))

    async def _diagnosis(self, robot: str) -> dict[str, Any]:
        path = f"{path_of('robots', robot, 'diagnosis')}?seconds={self._seconds:g}"
        diagnosis: dict[str, Any] = await self._client.get(path)
        return diagnosis

    async def _reach(self) -> CloudFacts:
        """Return what is known of the cloud without its machines and robots."""
        before = monotonic()
        try:
            health = await self._client.get(path_of("health"))
            facts = _of_health(self._url, health, monotonic() - before)
        except (PPaaSError, KeyError, TypeError) as problem:
            return CloudFacts(url=self._url, problem=str(problem) or "it is not a PPaaS cloud", own_version=__version__)
        if not self._token:
            return msgspec.structs.replace(facts, token_problem="there is none: PPAAS_TOKEN is not set")
        try:
            me = await self._client.get(path_of("users", "me"))
        except (NotAuthenticated, NotPermitted) as problem:
            return msgspec.structs.replace(facts, token_problem=str(problem))
        return msgspec.structs.replace(facts, user=me["id"])

    async def _machines(self) -> list[MachineFacts] | None:
        try:
            found = await self._client.items(path_of("machines"))
        except NotPermitted:
            return None
        return [
            MachineFacts(name=each["id"], state=each["state"], capacity=each["capacity"], given=each["given"])
            for each in found
        ]

    async def _robots(self) -> list[RobotLine]:
        turns = asyncio.Semaphore(MOST_AT_ONCE)

        async def line(robot: str) -> RobotLine:
            async with turns:
                return _line(robot, await self._diagnosis(robot))

        robots = [each["id"] for each in await self._client.items(path_of("robots"))]
        return list(await asyncio.gather(*map(line, robots)))


def _of_health(url: str, health: dict[str, Any], took: float) -> CloudFacts:
    disk = health.get("disk") or {}
    state = disk.get("state", "ok")
    return CloudFacts(
        url=url,
        round_trip=took,
        version=health.get("version", ""),
        own_version=__version__,
        ahead=epoch() - took / 2.0 - health["time"] if "time" in health else 0.0,
        away={
            words: health[name].get("reason") or "" for name, words in STORES.items() if health[name]["state"] != "ok"
        },
        disk="ok" if state != "full" else f"it is {state}: {disk.get('reason') or 'no reason is known'}",
        plans_waiting=health["plans_waiting"],
    )


def _line(robot: str, diagnosis: dict[str, Any]) -> RobotLine:
    findings, level, connected = diagnosis["findings"], diagnosis["level"], diagnosis["connected"]
    absent = next((each for each in findings if each["kind"] == "robot-not-connected"), None)
    if absent is not None and len(findings) == 1:  # a robot that is switched off is no trouble
        return RobotLine(name=robot, connected=connected, level="ok", text="it is not connected.")
    text = findings[0]["text"] if findings else "all is well."
    return RobotLine(name=robot, connected=connected, level=level, text=text)


def _unknown(robot: str, known: list[str], text: str) -> Finding:
    alike = nearest(robot, known)
    hint = f" Did you mean '{alike}'?" if alike else ""
    return error("robot-unknown", f"{text}.", f"Your robots: {names(known)}.{hint}")


def _report(facts: CloudFacts, findings: list[Finding]) -> dict[str, Any]:
    return {
        "cloud": facts.url,
        "level": worst(findings),
        "findings": msgspec.to_builtins(findings),
        "robots": msgspec.to_builtins(facts.robots),
    }


OF_A_CLOUD = ("uvicorn", "zenoh", "argon2")
"""Modules that are installed together only where a cloud may be started."""


def with_packages(report: dict[str, Any]) -> dict[str, Any]:
    """Return a diagnosis with a finding about the packages of this computer, if some do not fit."""
    unfit = misfits(BASE, "cloud") if all(map(find_spec, OF_A_CLOUD)) else misfits(BASE)
    if not unfit:
        return report
    text = f"Packages on this computer are of versions that ppaas does not work with: {', '.join(map(str, unfit))}."
    finding = msgspec.to_builtins(error("packages-unfit", text, f"Run: {pip_command(unfit)}"))
    return report | {"level": "error", "findings": [finding, *report["findings"]]}


# -- view of a diagnosis as text ---------------------------------------------------------------------------------------

WIDTH = 100
"""Width of a line [characters]."""

MARKS = {"error": "ERROR", "warn": "WARN", "ok": "OK"}
COLUMNS = ("topic", "type", "rate", "size", "data", "last", "late", "refused")
INDENT = 7


def as_text(report: dict[str, Any]) -> str:
    """Return a diagnosis of a robot or of a cloud as text."""
    lines = [_heading(report), ""]
    for finding in report["findings"]:
        lines += _finding(finding)
    if not report["findings"]:
        lines.append("OK     Everything that the cloud checks is in order.")
    if report.get("topics") and report.get("connected"):
        lines += ["", *table([_row(topic) for topic in report["topics"]], COLUMNS)]
    if report.get("frames"):
        lines += ["", *_wrapped(f"frames: {_frames(report['frames'])}", "")]
    return "\n".join(lines) + "\n"


def _heading(report: dict[str, Any]) -> str:
    counts = Counter(finding["level"] for finding in report["findings"])
    found = [_count(counts[level], word) for level, word in (("error", "error"), ("warn", "warning")) if counts[level]]
    name = report["robot"] if "robot" in report else f"cloud {report['cloud']}"
    watched = f" (watched for {report['seconds']:.1f} s)" if report.get("seconds") else ""
    return printable(f"{name}: {', '.join(found) or 'all is well'}{watched}")


def _count(number: int, word: str) -> str:
    return f"{number} {word}{'' if number == 1 else 's'}"


def _finding(finding: dict[str, Any]) -> list[str]:
    lines = _wrapped(finding["text"], f"{MARKS[finding['level']]:<{INDENT}}")
    return [*lines, *_wrapped(finding["advice"], " " * INDENT + "→ ")] if finding["advice"] else lines


def _wrapped(text: str, first: str) -> list[str]:
    return textwrap.wrap(printable(text), WIDTH, initial_indent=first, subsequent_indent=" " * len(first))


def _row(topic: dict[str, Any]) -> dict[str, Any]:
    came = topic["silence"] is not None
    return {
        "topic": topic["name"],
        "type": topic["type"] or None,
        "rate": hertz(topic["rate"]) if came else None,
        "size": size(topic["size"]) if topic["size"] else None,
        "data": f"{size(topic['bandwidth'])}/s" if topic["bandwidth"] else None,
        "last": f"{seconds(topic['silence'])} ago" if came else "never",
        "late": None if topic["late"] is None else seconds(topic["late"]),
        "refused": topic["refused"] or None,
    }


def _frames(frames: list[dict[str, Any]]) -> str:
    return ", ".join(f"{each['parent']} → {each['name']}{' (static)' if each['static'] else ''}" for each in frames)
