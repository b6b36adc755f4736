"""Trial of a lift or a door: its states are shown, and orders sent until it has obeyed."""

import argparse
import asyncio
import contextlib
import json
import sys
from dataclasses import dataclass
from typing import Any

import msgspec

from engine.devices.base import DeviceUrl
from engine.devices.hosts import DeviceHosts
from engine.devices.opening import open_door, open_lift
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.buildings.doors.states import DoorRequest
from ppaas.buildings.lifts.states import EndSession, LiftRequest
from ppaas.errors import InvalidInput, PPaaSError, Unavailable

HEARTBEAT = 1.0
"""Time between two requests of the session [s], as the controller of a building repeats them."""

SESSION = "ppaas/try"


def run(arguments: argparse.Namespace) -> None:
    """Try the device of the arguments of ``ppaas device try``.

    Raises
    ------
    InvalidInput
        The URL or a floor is not valid.
    Unavailable
        The device reports nothing, or does not obey in time.
    """
    asyncio.run(_try(_trial_of_door(arguments) if arguments.door or arguments.open else _trial_of_lift(arguments)))


@dataclass(frozen=True, slots=True)
class _Trial:
    """What is tried.

    Parameters
    ----------
    device : LiftDevice or DoorDevice
    begin, end : LiftRequest, EndSession, DoorRequest
        Orders by which it is held and let go.
    reached : dict of str to str
        Members of the state that is waited for; none if states are only shown.
    arguments : argparse.Namespace
    """

    device: Any
    begin: Any
    end: Any
    reached: dict[str, str]
    arguments: argparse.Namespace


def _trial_of_lift(arguments: argparse.Namespace) -> _Trial:
    floors = [floor.strip() for floor in arguments.floors.split(",") if floor.strip()]
    wanted = arguments.floor
    if not floors or len(set(floors)) < len(floors):
        raise InvalidInput("--floors has the name of each floor once, such as L1,L2")
    if wanted is not None and wanted not in floors:
        raise InvalidInput(f"--floors has no floor {wanted!r}: {', '.join(floors)}")
    levels = {name: 3.0 * level for level, name in enumerate(floors)}
    device = open_lift(LiftSettings(lift="lift", device=arguments.url), levels, _hosts(arguments.url))
    reached = {"floor": wanted, "door": "open", "motion": "stopped", "session": SESSION} if wanted else {}
    return _Trial(device, LiftRequest("lift", SESSION, wanted or ""), EndSession("lift", SESSION), reached, arguments)


def _trial_of_door(arguments: argparse.Namespace) -> _Trial:
    device = open_door(DoorSettings(floor="floor", door="door", device=arguments.url), _hosts(arguments.url))
    begin, end = DoorRequest("floor", "door", SESSION, "open"), DoorRequest("floor", "door", SESSION, "closed")
    return _Trial(device, begin, end, {"mode": "open"} if arguments.open else {}, arguments)


def _hosts(url: str) -> DeviceHosts:
    """Return the hosts that may be connected to: the host of the URL, which the operator has typed."""
    parsed = DeviceUrl.parse(url)
    return DeviceHosts([parsed.host] if parsed.host else [])


async def _try(trial: _Trial) -> None:
    """Show states, and send orders until the device has obeyed."""
    loop = asyncio.get_running_loop()
    began, obeyed = loop.time(), asyncio.Event()
    seen: list[dict[str, Any]] = []

    def show(state: Any) -> None:
        members = msgspec.to_builtins(state)
        if not seen or seen[-1] != members:
            seen.append(members)
            _print(loop.time() - began, members, as_json=trial.arguments.json)
        if trial.reached and trial.reached.items() <= members.items():
            obeyed.set()

    running = asyncio.create_task(trial.device.run(show))
    holding = asyncio.create_task(_hold(trial))
    waiting = asyncio.create_task(obeyed.wait())
    ends = (running, waiting, holding) if trial.reached else (running, waiting)
    try:
        await asyncio.wait(ends, timeout=trial.arguments.seconds, return_when=asyncio.FIRST_COMPLETED)
    finally:
        holding.cancel()
        if trial.reached:
            with contextlib.suppress(PPaaSError):  # the device may be lost, which is reported below
                await trial.device.send(trial.end)
        waiting.cancel()
        running.cancel()
        results = await asyncio.gather(running, holding, waiting, return_exceptions=True)
    failure = next((each for each in results if isinstance(each, Exception)), None)
    if failure is not None and not obeyed.is_set():
        raise failure
    if not seen:
        raise Unavailable(f"the device reported nothing within {trial.arguments.seconds:g} s")
    if trial.reached and not obeyed.is_set():
        raise Unavailable(f"the device did not obey within {trial.arguments.seconds:g} s: {seen[-1]}")


async def _hold(trial: _Trial) -> None:
    """Repeat the request; one that is too early, before the connection, is sent again soon."""
    while trial.reached:
        try:
            await trial.device.send(trial.begin)
            await asyncio.sleep(HEARTBEAT)
        except Unavailable:
            await asyncio.sleep(0.1 * HEARTBEAT)


def _print(seconds: float, members: dict[str, Any], *, as_json: bool) -> None:
    if as_json:
        line = json.dumps({"seconds": round(seconds, 2), **members})
    else:
        words = [
            f"{name}={','.join(value) if isinstance(value, list | tuple) else value}" for name, value in members.items()
        ]
        line = f"{seconds:7.2f} s  {'  '.join(word for word in words if not word.endswith('='))}"
    sys.stdout.write(line + "\n")
    sys.stdout.flush()
