"""Entry points of test containers, in place of the real one; each takes a ``Launch``."""

import os
import socket
import sys
import threading
import time
from pathlib import Path

from engine.specs.containers import Launch

BURNING = 0.5
"""Duration of ``burn`` [s]."""

HELD = 1100
"""Memory that ``hold_memory`` takes [MiB]."""


def report(launch: Launch, text: str) -> socket.socket:
    """Dial ``launch.link``, send a text, and return the open connection."""
    connection = socket.socket(socket.AF_UNIX)
    connection.connect(launch.link)
    connection.sendall(f"{launch.spec.id} {os.getpid()} {text}\n".encode())
    return connection


def dial_and_stay(launch: Launch) -> None:
    """Report that it runs, and run until it is killed."""
    with report(launch, "ready"):
        while True:
            time.sleep(60)


def describe(launch: Launch) -> int:
    """Report CPUs, threads, session and environment; exit with status 7."""
    import numba

    facts = {
        "cpus": _cpus(),
        "threads": numba.get_num_threads(),
        "session": os.getsid(0) == os.getpid(),
        "omp": os.environ["OMP_NUM_THREADS"],
        "main": "pytest" in sys.modules,
        "told_ray_token": any(name.startswith("RAY_AUTH") for name in os.environ),
        "alone": threading.active_count(),
    }
    report(launch, " ".join(f"{name}={value}" for name, value in facts.items())).close()
    return 7


def hold_the_interpreter(launch: Launch) -> None:
    """Report that it runs, then hold the interpreter's lock for ever."""
    import re

    with report(launch, "ready"):
        re.match("(a+)+b", "a" * 64)


def live_again(launch: Launch) -> int:
    """Run the warm-up in a forked process, and report the modules and kernels that it had to load."""
    from engine.container.warm_up.scripted_session import warm_up
    from engine.runtimes.compilation.kernel_modules import loaded as kernel_modules

    def loaded() -> set[str]:
        kernels = (found for module in kernel_modules() for found in vars(module).values() if hasattr(found, "py_func"))
        return {
            *sys.modules,
            *(f"{kernel.py_func.__name__}{signature}" for kernel in kernels for signature in kernel.signatures),
        }

    known = loaded()
    warm_up()
    report(launch, f"loaded: {sorted(loaded() - known)}").close()
    return 0


def tell_tuning(launch: Launch) -> int:
    """Run the warm-up, and report whether the robot drove, and how the memory of this process is tuned."""
    from numba.core.caching import Cache

    from engine.container.warm_up.scripted_session import warm_up
    from engine.runtimes.memory_tuning.stub_modules import HTML, MASKED, TLS

    facts = {
        "drove": "cmd_vel" in warm_up(),
        "spared": not {HTML, MASKED, TLS} & sys.modules.keys(),
        "without_compiler": hasattr(Cache.load_overload, "__wrapped__"),
    }
    report(launch, " ".join(f"{name}={value}" for name, value in facts.items())).close()
    return 0


def burn(launch: Launch) -> None:
    """Keep two processes busy for half a second, and report how many CPUs they got on average."""
    began = time.monotonic()
    children = [_burn(BURNING) for _ in range(2)]
    used = sum(usage.ru_utime + usage.ru_stime for _, _, usage in (os.wait4(child, 0) for child in children))
    report(launch, str(used / (time.monotonic() - began))).close()


def _burn(seconds: float) -> int:
    child = os.fork()
    if child == 0:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            pass
        os._exit(0)
    return child


def compete(launch: Launch) -> None:
    """Be busy for a second, and report the CPU time [s]."""
    began, used = time.monotonic(), time.process_time()
    while time.monotonic() - began < 1.0:
        pass
    report(launch, str(time.process_time() - used)).close()


def read_layers(launch: Launch) -> None:
    """Report the layers that it sees, then a file that is added to them."""
    folder = Path(launch.layers)
    with report(launch, (folder / "info.json").read_text()) as connection:
        while not (late := folder / "late.index").exists():
            time.sleep(0.005)
        connection.sendall(f"{launch.spec.id} {os.getpid()} {late.read_text()}\n".encode())


def tell_cpus(launch: Launch) -> None:
    """Report the CPUs that it may run on, and again whenever they change."""
    with report(launch, cpus := _cpus()) as connection:
        while True:
            if (now := _cpus()) != cpus:
                cpus = now
                connection.sendall(f"{launch.spec.id} {os.getpid()} {cpus}\n".encode())
            time.sleep(0.005)


def _cpus() -> str:
    return ",".join(map(str, sorted(os.sched_getaffinity(0))))


def hold_memory(launch: Launch) -> None:
    """Take most of the memory of a container of two cores, report it, and keep it."""
    taken = bytearray(os.urandom(1 << 20)) * HELD
    with report(launch, f"{len(taken) >> 20} MiB"):
        while True:
            time.sleep(60)


def take_memory_if_told(launch: Launch) -> None:
    """Take more and more memory if the secret is ``take``, otherwise stay."""
    if launch.secret == "take":
        take_memory(launch)
    dial_and_stay(launch)


def take_memory(launch: Launch) -> None:
    """Take more and more memory."""
    taken = []
    while True:
        taken.append(bytearray(os.urandom(1 << 20)) * 32)
