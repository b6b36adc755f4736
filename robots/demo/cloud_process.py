"""A cloud of one's own, as a process that lives as long as a demo."""

import asyncio
import contextlib
import os
import signal
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

import msgspec

from ppaas.errors import Unavailable
from robots import cli


class CloudReady(msgspec.Struct, frozen=True):
    """What the cloud writes once it is up."""

    url: str
    pid: int
    admin_user: str


class CloudProcess:
    """Runs ``ppaas up`` in a folder of its own that is removed afterwards.

    Parameters
    ----------
    start_timeout : float
        Seconds in which it must be up.
    stop_timeout : float
        Seconds that it has to end by itself.
    arguments : sequence of str
        Of ``ppaas up``, beside those that make it a cloud of its own.
    environment : mapping of str, optional
        Variables to set for it.
    """

    def __init__(
        self,
        start_timeout: float = 600.0,
        stop_timeout: float = 15.0,
        arguments: Sequence[str] = (),
        environment: Mapping[str, str] | None = None,
    ) -> None:
        self._arguments = arguments
        self._environment = dict(environment or {})
        self._start_timeout = start_timeout
        self._stop_timeout = stop_timeout
        self._folder = tempfile.TemporaryDirectory(prefix="ppaas-", ignore_cleanup_errors=True)
        self._process: asyncio.subprocess.Process | None = None
        self.ready = CloudReady("", 0, "")

    @property
    def folder(self) -> Path:
        """Where its files are."""
        return Path(self._folder.name)

    @property
    def password(self) -> str:
        """The administrator's."""
        return (self.folder / "password").read_text().strip()

    async def __aenter__(self) -> Self:
        """Start it and wait until it is up.

        Raises
        ------
        Unavailable
            It ended or was not up in time; the text has the end of its log.
        """
        try:
            await self._come_up()
        except BaseException:
            await self._stop()
            raise
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._stop()

    @property
    def status(self) -> int | None:
        """With which it ended, the last time that it did; None while it runs."""
        return self._process.returncode if self._process is not None else None

    async def ended(self) -> None:
        """Wait until it has ended, however that came."""
        if self._process is not None:
            await self._process.wait()

    async def again(self) -> None:
        """Start it again with the data that it had, after it has ended.

        Raises
        ------
        Unavailable
            It ended or was not up in time; the text has the end of its log.
        """
        (self.folder / "ready.json").unlink(missing_ok=True)
        await self._come_up()

    async def end(self) -> None:
        """End it, by force if it does not go by itself; its folder stays."""
        if self._process is not None:
            await self._end(self._process)

    async def _come_up(self) -> None:
        await self._start()
        self.ready = await self._wait_ready(self._start_timeout)

    async def _start(self) -> None:
        command = [sys.executable, "-m", cli.__name__, "up", "--host", "127.0.0.1", "--port", "0"]
        command += ["--data", str(self.folder / "data"), "--ready-file", str(self.folder / "ready.json")]
        command += ["--admin-password-file", str(self.folder / "password"), "--log-level", "warning"]
        command += self._arguments
        with (self.folder / "log").open("ab") as log:
            # A session of its own: Ctrl-C ends the demo, and the demo ends the cloud. Its temporary files go with ours.
            self._process = await asyncio.create_subprocess_exec(
                *command,
                stdin=asyncio.subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env=os.environ | {"TMPDIR": self._folder.name} | self._environment,
                start_new_session=True,
            )

    async def _wait_ready(self, patience: float) -> CloudReady:
        assert self._process is not None
        ended = asyncio.create_task(self._process.wait())
        try:
            async with asyncio.timeout(patience):
                while not ended.done():
                    found = self._read_ready()
                    if found is not None:
                        return found
                    await asyncio.wait({ended}, timeout=0.05)
        except TimeoutError as error:
            raise Unavailable(f"the cloud was not up in {patience:g} s{self._log_end()}") from error
        finally:
            ended.cancel()
        raise Unavailable(f"the cloud ended with status {self._process.returncode}{self._log_end()}")

    def _read_ready(self) -> CloudReady | None:
        """Return what the ready file says; None while it is not there or not yet whole."""
        try:
            return msgspec.json.decode((self.folder / "ready.json").read_bytes(), type=CloudReady)
        except (FileNotFoundError, msgspec.DecodeError):
            return None

    def _log_end(self, lines: int = 20) -> str:
        text = (self.folder / "log").read_text(errors="replace").splitlines()[-lines:]
        return ":\n" + "\n".join(text) if text else ""

    async def _stop(self) -> None:
        try:
            await self.end()
        finally:
            self._folder.cleanup()

    async def _end(self, process: asyncio.subprocess.Process) -> None:
        try:
            if not self.ready.pid:
                # It was interrupted while it started, and ends in order only once it is up.
                with contextlib.suppress(Unavailable):
                    await self._wait_ready(self._stop_timeout)
            if process.returncode is None:
                process.send_signal(signal.SIGTERM)
                await asyncio.wait_for(process.wait(), self._stop_timeout)
        except TimeoutError:
            process.kill()
            await process.wait()
        finally:
            if process.returncode is None:
                process.kill()
