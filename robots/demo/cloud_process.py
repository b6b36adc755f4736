"""Cloud in a child process, for the duration of a demo or a bench, and the progress of its start."""

import asyncio
import contextlib
import os
import signal
import socket
import sys
import tempfile
from collections.abc import AsyncIterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import PPaaSError, Unavailable
from robots import cli
from robots.client.cloud_url import path_of
from robots.client.rest import RestClient
from robots.demo.options import CloudAccess, Write


class CloudReady(msgspec.Struct, frozen=True):
    """Content of the ready file that the cloud writes when it is up."""

    url: str
    pid: int
    admin_user: str


class CloudProcess:
    """Runs ``ppaas up`` with a folder for its data, its log and its temporary files.

    Parameters
    ----------
    start_timeout : float
        Time limit of the start [s].
    stop_timeout : float
        Time to exit after SIGTERM before it is killed [s].
    arguments : sequence of str
        Further arguments of ``ppaas up``.
    environment : mapping of str, optional
        Further environment variables.
    folder : Path, optional
        Existing folder, which is kept; by default a temporary one that is removed at the end.

    Attributes
    ----------
    arguments : sequence of str
        Further arguments, from the next start on.
    python : str
        Interpreter that runs it, from the next start on.
    folder : Path
        Folder with the files of the cloud.
    """

    def __init__(
        self,
        start_timeout: float = 600.0,
        stop_timeout: float = 15.0,
        arguments: Sequence[str] = (),
        environment: Mapping[str, str] | None = None,
        folder: Path | None = None,
    ) -> None:
        self.arguments = arguments
        self.python = sys.executable
        self._environment = dict(environment or {})
        self._start_timeout = start_timeout
        self._stop_timeout = stop_timeout
        self._temporary = contextlib.ExitStack()
        if folder is None:
            temporary = tempfile.TemporaryDirectory(prefix="ppaas-demo-", ignore_cleanup_errors=True)
            folder = Path(self._temporary.enter_context(temporary))
        self.folder = folder
        self._process: asyncio.subprocess.Process | None = None
        self.ready = CloudReady("", 0, "")

    @property
    def password(self) -> str:
        """Password of the administrator."""
        return (self.folder / "password").read_text().strip()

    async def __aenter__(self) -> Self:
        """Start the cloud and wait until it is up.

        Raises
        ------
        Unavailable
            The cloud exited or was not up in time; the text includes the end of its log.
        """
        try:
            await self._start_and_wait()
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
        """Exit status; None while the process runs."""
        return self._process.returncode if self._process is not None else None

    async def ended(self) -> None:
        """Wait until the process has exited."""
        if self._process is not None:
            await self._process.wait()

    async def begin(self) -> None:
        """Start the cloud without waiting until it is up, as one that stands by; also again, after it has exited."""
        await self._start()

    async def is_up(self) -> None:
        """Wait until a cloud that was begun is up.

        Raises
        ------
        Unavailable
            The cloud exited or was not up in time; the text includes the end of its log.
        """
        self.ready = await self._wait_ready(self._start_timeout)

    async def again(self) -> None:
        """Start the cloud again with the same data, after it has exited.

        Raises
        ------
        Unavailable
            The cloud exited or was not up in time; the text includes the end of its log.
        """
        await self._start_and_wait()

    async def stop(self) -> None:
        """Stop the cloud, also one that is not up yet, and remove its temporary folder."""
        await self._stop()

    def send(self, number: signal.Signals) -> None:
        """Send a signal to the process, if it runs."""
        if self._process is not None and self._process.returncode is None:
            self._process.send_signal(number)

    async def end(self) -> None:
        """Stop the cloud, with SIGKILL if SIGTERM does not suffice; its folder is kept."""
        if self._process is not None:
            await self._end(self._process)

    async def _start_and_wait(self) -> None:
        await self._start()
        await self.is_up()

    async def _start(self) -> None:
        (self.folder / "ready.json").unlink(missing_ok=True)  # that of an earlier start names a process that is gone
        command = [self.python, "-m", cli.__name__, "up", "--host", "127.0.0.1", "--port", "0"]
        command += ["--data", str(self.folder / "data"), "--ready-file", str(self.folder / "ready.json")]
        command += ["--admin-password-file", str(self.folder / "password"), "--log-level", "warning"]
        command += self.arguments
        with (self.folder / "log").open("ab") as log:
            # In its own session: on Ctrl-C the demo stops the cloud. Temporary files are removed with the folder.
            self._process = await asyncio.create_subprocess_exec(
                *command,
                stdin=asyncio.subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env=os.environ | self._own_files() | self._environment,
                start_new_session=True,
            )

    def _own_files(self) -> dict[str, str]:
        """Return variables that keep it off the settings of a cloud of this host, and off its temporary files."""
        return {"TMPDIR": str(self.folder), "PPAAS_CONFIG": os.devnull}

    async def _wait_ready(self, timeout: float) -> CloudReady:
        assert self._process is not None
        ended = asyncio.create_task(self._process.wait())
        try:
            async with asyncio.timeout(timeout):
                while not ended.done():
                    found = self._read_ready()
                    if found is not None:
                        return found
                    await asyncio.wait({ended}, timeout=0.05)
        except TimeoutError as error:
            raise Unavailable(f"the cloud was not up within {timeout:g} s{self._log_end()}") from error
        finally:
            ended.cancel()
        raise Unavailable(f"the cloud exited with status {self._process.returncode}{self._log_end()}")

    def _read_ready(self) -> CloudReady | None:
        """Return the content of the ready file; None while it is missing or incomplete."""
        try:
            return from_json((self.folder / "ready.json").read_bytes(), CloudReady)
        except (FileNotFoundError, msgspec.DecodeError):
            return None

    def _log_end(self, lines: int = 20) -> str:
        text = (self.folder / "log").read_text(errors="replace").splitlines()[-lines:]
        return ":\n" + "\n".join(text) if text else ""

    async def _stop(self) -> None:
        try:
            await self.end()
        finally:
            self._temporary.close()

    async def _end(self, process: asyncio.subprocess.Process) -> None:
        try:
            if not self.ready.pid:
                # Interrupted during the start: the cloud can shut down cleanly only once it is up.
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


# -- the cloud that a demo starts, and the progress of its start -------------------------------------------------------

PERIOD = 1.0
"""Period at which the cloud is asked [s]."""

STARTING = "the cloud is starting"
"""What is written first."""


@contextlib.asynccontextmanager
async def own_cloud(write: Write, arguments: Sequence[str] = ()) -> AsyncIterator[CloudAccess]:
    """Run a cloud with further arguments during the block, and write what it does until it is up.

    Raises
    ------
    Unavailable
        The cloud does not start; the text includes the end of its log.
    """
    write(STARTING)
    port = free_port()
    async with contextlib.AsyncExitStack() as stack:
        telling = asyncio.create_task(tell_start(f"http://127.0.0.1:{port}", write))
        try:
            cloud = await stack.enter_async_context(CloudProcess(arguments=("--port", str(port), *arguments)))
        finally:
            telling.cancel()
            await asyncio.gather(telling, return_exceptions=True)
        yield CloudAccess(cloud.ready.url, cloud.ready.admin_user, cloud.password)


async def tell_start(url: str, write: Write) -> None:
    """Tell what a cloud does while it is starting, whenever that has changed, until cancelled.

    Parameters
    ----------
    url : str
        URL of the cloud, which need not serve yet.
    write : callable
        Called with each text.
    """
    rest, told = RestClient(url), STARTING
    while True:
        with contextlib.suppress(PPaaSError):  # it does not serve yet
            text = start_text(await rest.get(path_of("health")))
            if text and text != told:
                told = text
                write(text)
        await asyncio.sleep(PERIOD)


def start_text(health: dict[str, Any]) -> str:
    """Return what a cloud does, by its health, while it is starting; empty if it is not."""
    if health["status"] != "starting":
        return ""
    kernels = health["kernels"]
    if kernels is None:
        return STARTING
    now = f" (now {', '.join(kernels['compiling'])})" if kernels["compiling"] else ""
    return f"{STARTING}: compiling kernels, {kernels['done']} of {kernels['total']}{now}"


def free_port() -> int:
    """Return a TCP port of this computer that nobody uses now."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
    return port
