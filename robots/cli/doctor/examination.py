"""Examination of a cloud and of its robots over REST."""

import asyncio
from typing import Any

import msgspec

from ppaas import __version__
from ppaas.clock import epoch, monotonic
from ppaas.diagnosis.observations.cloud import CloudFacts, MachineFacts, RobotLine
from ppaas.diagnosis.rules.cloud import cloud
from ppaas.diagnosis.rules.finding import Finding, error, names, nearest, worst
from ppaas.errors import NotAuthenticated, NotFound, NotPermitted, PPaaSError
from robots.client.rest import RestClient
from robots.client.rest_paths import path_of

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
