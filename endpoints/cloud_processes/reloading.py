"""Reload of settings in the process of a cloud: by SIGHUP, whether it leads or stands by."""

import asyncio
import contextlib
import logging
import os
import signal
from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import msgspec

from endpoints.audit.event import AuditEvent
from endpoints.audit.file_log import record_on_host
from endpoints.cloud_processes.cloud_jobs import CloudJobs
from endpoints.resources.services import Services
from endpoints.retention.service import Retention
from endpoints.settings.live import LiveSettings, live_settings
from endpoints.settings.reload import REPORT, ReloadReport, RunningSettings
from endpoints.webhooks.service import Webhooks
from endpoints.webhooks.targets import TargetRules
from engine.control.master_calls.cloud import Cloud
from engine.control.tasks.runner import TaskRunner
from engine.master.quotas import Quota
from engine.processes.background import Background
from engine.processes.private_files import write_private
from ppaas.clock import Clock, uptime
from ppaas.errors import PPaaSError

logger = logging.getLogger(__name__)


class SettingsReload:
    """Reads the settings of a cloud again while it runs; implements ``LiveCalls``.

    All settings are checked before any is applied.

    Parameters
    ----------
    running : RunningSettings
        Settings of the process.
    clock : callable
        Returns the time since this host was started [s].

    Attributes
    ----------
    arguments : Namespace
        Settings in force.
    """

    def __init__(self, running: RunningSettings, clock: Clock = uptime) -> None:
        self.arguments = running.arguments
        self._running = running
        self._clock = clock
        self._live = live_settings(running.arguments)
        self._next = asyncio.Event()
        self._turn = asyncio.Lock()
        self._background = Background()
        self._parts: list[Callable[[Namespace], object]] = []

    def follow(self, apply: Callable[[Namespace], object]) -> None:
        """Call a function with the settings in force now, and whenever they have changed; it must not fail."""
        apply(self.arguments)
        self._parts.append(apply)

    async def changed(self, known: LiveSettings | None) -> LiveSettings:
        """Return the settings that endpoints follow once they are not the known ones."""
        while self._live == known:
            await self._next.wait()
        return self._live

    async def reload(self) -> ReloadReport:
        """Read the settings again, and apply what can be applied; return what differs.

        Raises
        ------
        InvalidInput
            A setting is misspelt or wrong; nothing was changed.
        Unavailable
            A package that they need is too old or too new; nothing was changed.
        """
        async with self._turn:
            arguments, report = await asyncio.to_thread(self._running.again)
            live = await asyncio.to_thread(live_settings, arguments)
            self._running.take(arguments)
            self._live, before = live, self._live
            for apply in self._parts:
                apply(self.arguments)
            if live != before:
                self._next.set()
                self._next = asyncio.Event()
        return report

    @property
    def live(self) -> LiveSettings:
        """Settings in force that endpoints follow."""
        return self._live

    # -- by a signal ---------------------------------------------------------------------------------------------------

    def on_hangup(self, end: asyncio.Event) -> None:
        """Reload at each SIGHUP; set ``end`` instead when the terminal of this process is gone."""
        in_terminal, begun = _has_terminal(), ReloadReport(pid=os.getpid(), began=self._clock())

        def hung_up() -> None:
            if in_terminal and not _has_terminal():
                logger.info("this process ends: its terminal is gone")
                end.set()
            else:
                self._background.run(self._reload_and_report())

        asyncio.get_running_loop().add_signal_handler(signal.SIGHUP, hung_up)
        _write(self.arguments.data, begun)

    async def close(self) -> None:
        """Reload no more."""
        asyncio.get_running_loop().remove_signal_handler(signal.SIGHUP)
        await self._background.cancel()

    async def _reload_and_report(self) -> None:
        began, data = self._clock(), self.arguments.data
        try:
            report = msgspec.structs.replace(await self.reload(), pid=os.getpid(), began=began)
            event = AuditEvent(action="reload_settings", details=_details(report))
            logger.info("the settings were read again: %s", report)
        except PPaaSError as error:
            report = ReloadReport(pid=os.getpid(), began=began, problem=str(error))
            event = AuditEvent(action="reload_settings", outcome="refused", reason=error.slug)
            logger.error("the settings stay as they are: %s", error)
        await asyncio.to_thread(_store, data, report, event)


@dataclass(frozen=True, slots=True)
class FollowingMaster:
    """Parts of the process of the master that follow its settings."""

    cloud: Cloud
    services: Services
    jobs: CloudJobs
    webhooks: Webhooks
    retention: Retention
    tasks: TaskRunner

    def apply(self, arguments: Namespace) -> None:
        """Put settings into force."""
        logging.getLogger().setLevel(arguments.log_level.upper())
        quota = Quota(**dict(arguments.quota))
        if quota != self.cloud.quotas.default:
            self.cloud.driver.set_default_quota(quota)
        self.services.keep_versions = arguments.keep_versions
        self.jobs.idle.change(arguments.idle)
        self.webhooks.allow(target_rules(arguments))
        self.retention.change(dict(arguments.retention), dict(arguments.retention_size))
        self.tasks.keep_for(self.retention.seconds("tasks"))


def target_rules(arguments: Namespace) -> TargetRules:
    """Return what the options allow as targets of webhooks."""
    return TargetRules(allow_private=arguments.webhook_allow_private, allow_http=arguments.webhook_allow_http)


def _details(report: ReloadReport) -> dict[str, object]:
    applied = {one.key: [one.before, one.after] for one in report.changed if one.applied}
    return {"changed": applied, "needs_restart": [one.key for one in report.changed if not one.applied]}


def _store(data: Path, report: ReloadReport, event: AuditEvent) -> None:
    record_on_host(data, event)
    _write(data, report)


def _write(data: Path, report: ReloadReport) -> None:
    try:
        write_private(data / REPORT, msgspec.json.encode(report))
    except OSError as error:
        logger.warning("the report of the reload cannot be written: %s", error)


def _has_terminal() -> bool:
    with contextlib.suppress(OSError):
        os.close(os.open("/dev/tty", os.O_RDONLY | os.O_NOCTTY))
        return True
    return False
