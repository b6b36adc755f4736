"""Opens devices by URL: our own drivers, and drivers of other distributions by entry point."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping

from engine.devices.base import DeviceDriver, DeviceUrl, DoorDevice, LiftDevice
from engine.devices.hosts import DeviceHosts
from engine.processes.occasional_log import OccasionalLog
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.errors import InvalidInput, NotFound, PPaaSError
from ppaas.plugins import PluginRegistry

logger = logging.getLogger(__name__)

DEVICES: PluginRegistry[DeviceDriver] = PluginRegistry("ppaas.devices", "device", DeviceDriver, {})  # type: ignore[type-abstract]

FIRST_PAUSE, LAST_PAUSE = 0.5, 5.0
"""Pause before a device that was lost is connected again [s]; doubled each time, up to the last."""


def open_lift(settings: LiftSettings, levels: Mapping[str, float], hosts: DeviceHosts) -> LiftDevice:
    """Return the device of a lift, not connected yet.

    Raises
    ------
    InvalidInput
        Its URL is not valid; the text lists the schemes if the scheme is unknown.
    NotPermitted
        A plug-in of another distribution opens it, which no administrator has allowed.
    """
    driver, url = _driver(settings.device)
    return driver.lift(url, settings, levels, hosts)


def open_door(settings: DoorSettings, hosts: DeviceHosts) -> DoorDevice:
    """Return the device of a door, not connected yet; raise as ``open_lift``."""
    driver, url = _driver(settings.device)
    return driver.door(url, settings, hosts)


def _driver(text: str) -> tuple[DeviceDriver, DeviceUrl]:
    url = DeviceUrl.parse(text)
    try:
        driver = DEVICES.create(url.scheme, {})
    except NotFound as error:
        known = ", ".join(f"{name}:" for name in DEVICES.names())
        raise InvalidInput(f"unknown scheme of a device {url.scheme!r}; known: {known}") from error
    if driver.remote and not url.host:
        raise InvalidInput(f"the URL of a device of {url.scheme}: has a host, such as {url.scheme}://10.0.0.7")
    return driver, url


async def keep_connected(name: str, run: Callable[[], Awaitable[None]]) -> None:
    """Run a device until cancelled, again after each failure; the log names it."""
    log, pause = OccasionalLog(logger), FIRST_PAUSE
    while True:
        began = asyncio.get_running_loop().time()
        try:
            await run()
        except PPaaSError as error:
            log.warning("%s: %s", name, error)
        except Exception:
            logger.exception("%s: its driver failed", name)
        if asyncio.get_running_loop().time() - began > LAST_PAUSE:
            pause = FIRST_PAUSE
        await asyncio.sleep(pause)
        pause = min(2.0 * pause, LAST_PAUSE)
