"""A real server in a Java process, which can be started, stopped, killed, frozen and started again on its data."""

import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path

START_TIMEOUT = 180.0
STOP_TIMEOUT = 30.0


class JavaServer:
    """A server in a Java process.

    Parameters
    ----------
    command : sequence of str
        Command with all arguments.
    folder : Path
        Working directory; it gets the log ``<name>.log``.
    name : str
        Name of the log.
    is_ready : callable
        Returns whether the server is ready; it may raise until then.
    """

    def __init__(self, command: Sequence[str], folder: Path, name: str, is_ready: Callable[[], bool]) -> None:
        self.log = folder / f"{name}.log"
        self._command = command
        self._folder = folder
        self._is_ready = is_ready
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def pid(self) -> int:
        """The process; the server must have been started."""
        assert self._process is not None
        return self._process.pid

    @property
    def runs(self) -> bool:
        """Whether the server was started, and neither stopped nor killed since."""
        return self._process is not None

    def start(self) -> None:
        """Start the server and wait until it is ready."""
        self.launch()
        self.wait_ready()

    def launch(self) -> None:
        """Start the server without waiting."""
        assert self._process is None, "it runs already"
        with self.log.open("ab") as log:
            self._process = subprocess.Popen(
                self._command, cwd=self._folder, stdin=subprocess.DEVNULL, stdout=log, stderr=log
            )

    def wait_ready(self) -> None:
        """Wait until the server is ready."""
        deadline = time.monotonic() + START_TIMEOUT
        while not self._serves():
            assert self._process is not None and self._process.poll() is None, self._end_of_log()
            assert time.monotonic() < deadline, self._end_of_log()
            time.sleep(0.1)

    def stop(self) -> None:
        """Stop the server cleanly, if it runs."""
        if self._process is None:
            return
        self._process.send_signal(signal.SIGCONT)
        self._process.terminate()
        try:
            self._process.wait(STOP_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process = None

    def kill(self) -> None:
        """Kill the server with SIGKILL, so that it writes nothing more."""
        assert self._process is not None
        self._process.kill()
        self._process.wait()
        self._process = None

    def freeze(self) -> None:
        """Freeze the process: it stays connected and does not respond."""
        assert self._process is not None
        self._process.send_signal(signal.SIGSTOP)

    def thaw(self) -> None:
        """Continue a frozen process."""
        assert self._process is not None
        self._process.send_signal(signal.SIGCONT)

    def _serves(self) -> bool:
        try:
            return self._is_ready()
        except Exception:  # noqa: BLE001 - any error of the client while the server starts
            return False

    def _end_of_log(self) -> str:
        return self.log.read_text(errors="replace")[-4000:]
