"""A real server in a Java process: started, awaited, stopped, killed and started again over the same data."""

import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path

START_TIMEOUT = 90.0
STOP_TIMEOUT = 30.0


class JavaServer:
    """A Java process that serves.

    Parameters
    ----------
    command : sequence of str
        With all arguments.
    folder : Path
        Where it runs; its output is in ``<name>.log`` there.
    name : str
        How the log is called.
    is_ready : callable
        Tells whether it serves; it may raise as long as it does not.
    """

    def __init__(self, command: Sequence[str], folder: Path, name: str, is_ready: Callable[[], bool]) -> None:
        self.log = folder / f"{name}.log"
        self._command = command
        self._folder = folder
        self._is_ready = is_ready
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def pid(self) -> int:
        """The process, which must have been started."""
        assert self._process is not None
        return self._process.pid

    @property
    def runs(self) -> bool:
        """Whether it was started, and neither stopped nor killed since."""
        return self._process is not None

    def start(self) -> None:
        """Start it and wait until it serves."""
        self.launch()
        self.wait_ready()

    def launch(self) -> None:
        """Start it and do not wait."""
        assert self._process is None, "it runs already"
        with self.log.open("ab") as log:
            self._process = subprocess.Popen(
                self._command, cwd=self._folder, stdin=subprocess.DEVNULL, stdout=log, stderr=log
            )

    def wait_ready(self) -> None:
        """Wait until it serves."""
        deadline = time.monotonic() + START_TIMEOUT
        while not self._serves():
            assert self._process is not None and self._process.poll() is None, self._end_of_log()
            assert time.monotonic() < deadline, self._end_of_log()
            time.sleep(0.1)

    def stop(self) -> None:
        """End it cleanly, if it runs."""
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
        """Kill it with SIGKILL: it gets to write nothing more."""
        assert self._process is not None
        self._process.kill()
        self._process.wait()
        self._process = None

    def freeze(self) -> None:
        """Stop it where it stands: it is connected and does not answer."""
        assert self._process is not None
        self._process.send_signal(signal.SIGSTOP)

    def thaw(self) -> None:
        """Let it go on."""
        assert self._process is not None
        self._process.send_signal(signal.SIGCONT)

    def _serves(self) -> bool:
        try:
            return self._is_ready()
        except Exception:  # noqa: BLE001 - whatever its client says of a server that is not there yet
            return False

    def _end_of_log(self) -> str:
        return self.log.read_text(errors="replace")[-4000:]
