"""What the joints run in forked containers; importing this runs the kernels once, as the fork server does."""

import os
import threading
import time

import msgspec
import numba
import numpy as np

from engine.fabric.zenoh_config import RouterCredentials, client_config
from engine.runtimes.compilation.threading_layer import use_threads
from engine.specs.containers import Launch
from tests.support.engine.container_entries import report
from tests.support.stress.kernels import relax, roll_out, warm

warm()
WARMED_IN = os.getpid()


class Strain(msgspec.Struct):
    """What to do, handed over in place of the secret."""

    seconds: float
    router: str | None = None
    credentials: RouterCredentials | None = None


class Callers:
    """Threads that call kernels until time is up, and check what comes back."""

    def __init__(self, seconds: float, threads: int) -> None:
        self._until = time.monotonic() + seconds
        self._threads = threads
        self.calls = [0, 0]
        self.wrong: list[str] = []

    def plan(self) -> None:
        use_threads(self._threads)
        while time.monotonic() < self._until:
            grid = np.zeros((200, 200))
            grid[100] = -7.0
            for _ in range(5):
                grid = relax(grid)
            self._check(0, grid[100, 0] == -2.0 and grid[0, 0] == 5.0 and grid[103, 9] == -2.0, "relax")

    def control(self) -> None:
        use_threads(self._threads)
        speeds = np.full(1000, 0.5)
        while time.monotonic() < self._until:
            self._check(1, roll_out(speeds, 20) == 5000.0, "roll_out")

    def _check(self, caller: int, right: bool, name: str) -> None:
        self.calls[caller] += 1
        if not right:
            self.wrong.append(name)


def strain_kernels(launch: Launch) -> int:
    """Call kernels from two threads at once, beside a Zenoh session if one is asked for, and tell what came of it."""
    strain = msgspec.json.decode(launch.secret, type=Strain)
    from engine.runtimes.compilation.threading_layer import chosen

    session = None
    if strain.router is not None and strain.credentials is not None:
        import zenoh

        session = zenoh.open(client_config(strain.router, strain.credentials))
        session.declare_subscriber("ppaas/**", lambda sample: None)
    callers = Callers(strain.seconds, launch.threads)
    threads = [threading.Thread(target=target) for target in (callers.plan, callers.control)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if session is not None:
        session.close()
    layer = numba.threading_layer() if chosen() == "tbb" else chosen()
    forked_warm = os.getppid() == WARMED_IN
    report(launch, f"{forked_warm} {layer} {min(callers.calls)} {sum(callers.calls)} {callers.wrong}").close()
    return 0


def plan_once(launch: Launch) -> int:
    """Plan on shared layers, and tell what was compiled for it here, and how long it took from the first line on."""
    began = time.perf_counter()
    from pathlib import Path

    from numba.core import event

    from engine.specs.layer_files import open_layers
    from ppaas.geometry import Pose2D
    from ppaas.planners.base import PlanRequest
    from ppaas.planners.registry import create

    with event.install_recorder("numba:compile") as compiled:
        layers = open_layers(Path(launch.layers))
        request = PlanRequest(Pose2D(0.5, 0.5, 0.0), Pose2D(9.5, 9.5, 0.0), threads=launch.threads)
        result = create("dijkstra").plan(layers.costmap, request)
    milliseconds = (time.perf_counter() - began) * 1000.0
    with event.install_recorder("numba:compile") as control:
        numba.njit(lambda: 1)()
    names = sorted({str(seen.data["dispatcher"]) for _, seen in compiled.buffer}) if control.buffer else "unrecorded"
    report(launch, f"{milliseconds:.1f} {result.length:.2f} {names}").close()
    return 0
