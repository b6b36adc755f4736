"""Debian's mosquitto: a broker on this computer that a test may kill and start again."""

import os
import shutil
import socket
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path

import pytest

PATH = f"{os.environ['PATH']}:/usr/sbin"
START_TIMEOUT = 10.0


def program(name: str) -> str:
    """Return the path of a program of mosquitto, or skip the test."""
    return shutil.which(name, path=PATH) or pytest.skip(f"no {name}: install Debian's mosquitto (make broker)")


@dataclass
class Mosquitto:
    """Broker.

    Parameters
    ----------
    folder : Path
        Folder for its files.
    login : (str, str), optional
        User and password; without them, everybody may connect.
    certificate : (Path, Path), optional
        Files of a certificate and its key, for TLS.
    """

    folder: Path
    login: tuple[str, str] | None = None
    certificate: tuple[Path, Path] | None = None
    port: int = 0
    process: subprocess.Popen[bytes] | None = field(default=None, init=False)

    def start(self) -> None:
        """Start the broker, at the port that it had before."""
        self.port = self.port or _free_port()
        lines = [f"listener {self.port} 127.0.0.1", "user root", "persistence false", "set_tcp_nodelay true"]
        if self.login is None:
            lines.append("allow_anonymous true")
        else:
            passwords = self.folder / "passwords"
            passwords.touch(0o600)
            subprocess.run([program("mosquitto_passwd"), "-b", str(passwords), *self.login], check=True)
            lines += ["allow_anonymous false", f"password_file {passwords}"]
        if self.certificate is not None:
            lines += [f"certfile {self.certificate[0]}", f"keyfile {self.certificate[1]}"]
        config = self.folder / "mosquitto.conf"
        config.write_text("\n".join(lines) + "\n")
        with (self.folder / "mosquitto.log").open("ab") as log:
            self.process = subprocess.Popen([program("mosquitto"), "-c", str(config)], stdout=log, stderr=log)
        self._wait()

    def kill(self) -> None:
        """Kill the broker."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self.process = None

    @property
    def url(self) -> str:
        """URL of the broker, with the user and without the password."""
        scheme = "mqtt" if self.certificate is None else "mqtts"
        user = "" if self.login is None else f"{self.login[0]}@"
        return f"{scheme}://{user}localhost:{self.port}"

    def _wait(self) -> None:
        deadline = time.monotonic() + START_TIMEOUT
        while True:
            try:
                socket.create_connection(("127.0.0.1", self.port), timeout=1).close()
                return
            except OSError:
                assert self.process is not None
                if self.process.poll() is not None or time.monotonic() > deadline:
                    log = (self.folder / "mosquitto.log").read_text()
                    raise AssertionError(f"mosquitto did not start:\n{log}") from None
                time.sleep(0.02)


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port: int = listener.getsockname()[1]
        return port
