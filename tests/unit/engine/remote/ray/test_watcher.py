"""The loop of the watcher, fed by a pipe."""

import os
import threading

import pytest

from engine.remote.ray.watcher import serve


class Noting:
    """Replaces the supervisor, and records its calls."""

    def __init__(self) -> None:
        self.told: list[str] = []
        self.looked = threading.Event()

    def reconcile(self) -> None:
        self.looked.set()

    def kill_agent(self, machine: str) -> None:
        self.told.append(machine)

    def end_all(self) -> None:
        self.told.append("end all")


@pytest.mark.parametrize(("said", "told"), [(b"m1\nm2\n\n", ["m1", "m2", "end all"]), (b"m1\n", ["m1"])])
def test_it_supervises_without_commands_and_stops_agents_only_on_command(said: bytes, told: list[str]) -> None:
    reading, writing = os.pipe()
    noting = Noting()
    serving = threading.Thread(target=serve, args=(noting, reading))
    serving.start()
    assert noting.looked.wait(10.0)
    os.write(writing, said[:4])
    os.write(writing, said[4:])
    os.close(writing)
    serving.join(10.0)
    os.close(reading)
    assert noting.told == told
