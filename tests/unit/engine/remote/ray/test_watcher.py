"""The loop of the watcher, fed by a pipe."""

import os
import threading

import pytest

from engine.remote.ray.watcher import serve


class FakeSupervisor:
    """Replaces the supervisor, and records its calls."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.looked = threading.Event()

    def reconcile(self) -> None:
        self.looked.set()

    def kill_agent(self, machine: str) -> None:
        self.calls.append(machine)

    def end_all(self) -> None:
        self.calls.append("end all")


@pytest.mark.parametrize(("commands", "calls"), [(b"m1\nm2\n\n", ["m1", "m2", "end all"]), (b"m1\n", ["m1"])])
def test_watcher_stops_agents_on_command_only(commands: bytes, calls: list[str]) -> None:
    reading, writing = os.pipe()
    supervisor = FakeSupervisor()
    serving = threading.Thread(target=serve, args=(supervisor, reading))
    serving.start()
    assert supervisor.looked.wait(10.0)
    os.write(writing, commands[:4])
    os.write(writing, commands[4:])
    os.close(writing)
    serving.join(10.0)
    os.close(reading)
    assert supervisor.calls == calls
