"""``ppaas bench backup``: times of a backup, of the next one, and of a restoration, beside tar of the same files.

A backup and a restoration are killed at random moments, too, and robots drive while their cloud is backed up.
"""

import argparse
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import closing
from itertools import islice
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING

from ppaas.bounded import whole
from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from robots import cli
from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

    from benchmarks.stores.backup_robots import DrivenBackups

HELP = (
    "backups of many plans and large maps, killed ones, restorations, beside tar of the same files; and driving robots"
)

SIDE = 8192
"""Width and height of a map [cells]."""

AT_ONCE = 1000
"""Plans that are added at once."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "--plans", type=whole(100, 10_000_000), default=100_000, metavar="N", help="plans (%(default)s)"
    )
    parser.add_argument("--maps", type=whole(1, 1000), default=16, metavar="N", help="maps of 64 MiB (%(default)s)")
    parser.add_argument(
        "--kills", type=whole(0, 100), default=3, metavar="N",
        help="times that a backup, and a restoration, is killed at a random moment before it completes (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--robots", type=whole(0, 32), default=3, metavar="N",
        help="robots that drive while their cloud is backed up, and while it is not (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--turns", type=whole(1, 100), default=3, metavar="N", help="times that they do so (%(default)s)"
    )
    parser.add_argument("--encrypted", action="store_true", help="encrypt the backups")
    parser.add_argument("--folder", type=Path, default=Path(), help="folder on the disk to use (%(default)s)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the times, and their table."""
    import msgspec  # noqa: PLC0415 - ``ppaas bench --help`` loads this module

    with tempfile.TemporaryDirectory(prefix="ppaas-bench-", dir=arguments.folder) as name:
        folder = Path(name).resolve()  # the default is relative, which URLs of stores are not
        _add_plans(folder / "data", arguments.plans, progress)
        _add_maps(folder / "data", arguments.maps, progress)
        size = sum(file.stat().st_size for file in (folder / "data").rglob("*") if file.is_file())
        results = dict(_steps(folder, arguments, progress))
        driven = _driven(folder, arguments, progress) if arguments.robots else None
    rows = [
        {"step": step, "seconds": f"{seconds:.2f}", "MB/s of the stores": f"{size / 1e6 / seconds:,.0f}"}
        for step, seconds in results.items()
    ]
    if driven is not None:
        for text, gaps in (("without", driven.quiet), ("with", driven.backed_up)):
            step = f"p99 between commands of {driven.robots} robots, {text} a backup"
            rows.append({"step": step, "seconds": f"{gaps.p99 / 1e3:.3f}", "MB/s of the stores": "-"})
    result = {"plans": arguments.plans, "maps": arguments.maps, "bytes": size, "seconds": results}
    return Measured(result | {"robots": None if driven is None else msgspec.to_builtins(driven)}, rows)


def _driven(folder: Path, arguments: argparse.Namespace, progress: "Progress") -> "DrivenBackups":
    from benchmarks.stores.backup_robots import drive  # noqa: PLC0415

    for name in ("restored", "backups", "data.tar", "killed", "restored-killed"):  # space on the disk
        path = folder / name
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    return event_loop.run(drive(folder, arguments.robots, arguments.turns, progress))


def _steps(folder: Path, arguments: argparse.Namespace, progress: "Progress") -> list[tuple[str, float]]:
    task = progress.add_task("tar, backup, restore", total=7)
    place = [str(folder / "backups"), *(["--key-file", str(folder / "key")] if arguments.encrypted else [])]
    stores = ["--data", str(folder / "data"), "--json"]
    found = []

    def step(name: str, work: Callable[[], object]) -> None:
        began = monotonic()
        work()
        os.sync()
        found.append((name, monotonic() - began))
        progress.advance(task)

    os.sync()
    step("tar", lambda: _tar(folder))
    step("backup", lambda: _ppaas("backup", "create", *place, *stores))
    step("backup again", lambda: _ppaas("backup", "create", *place, *stores))
    step("check", lambda: _ppaas("backup", "check", *place))
    step("restore and compare", lambda: _ppaas("restore", *place, "--data", str(folder / "restored"), "--json"))
    if arguments.kills:
        times, killing = dict(found), Random(1)
        killed = [str(folder / "killed"), *place[1:]]
        restored = ["restore", *killed, "--data", str(folder / "restored-killed"), "--json"]
        for name, command in (("backup", ["backup", "create", *killed, *stores]), ("restore and compare", restored)):
            moments = [killing.uniform(0.0, times[name]) for _ in range(arguments.kills)]
            step(f"{name}, killed {arguments.kills} times", lambda c=command, m=moments: _ppaas_killed(c, m))  # type: ignore[misc]
    return found


def _ppaas_killed(command: Sequence[str], moments: Sequence[float]) -> None:
    """Run a command that is killed some time after its start [s], for each of these times; then to its end.

    Raises
    ------
    Unavailable
        It ended with an error: something was lost.
    """
    for moment in moments:
        process = subprocess.Popen([sys.executable, "-m", cli.__name__, *command], stdout=subprocess.DEVNULL)
        try:
            status = process.wait(moment)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
            continue
        if status:
            raise Unavailable(f"ppaas {command[0]} ended with status {status} after it had been killed")
    _ppaas(*command)


def _ppaas(*command: str) -> None:
    subprocess.run([sys.executable, "-m", cli.__name__, *command], check=True, stdout=subprocess.DEVNULL)


def _tar(folder: Path) -> None:
    subprocess.run(["tar", "-C", str(folder), "-cf", str(folder / "data.tar"), "data"], check=True)


def _add_plans(data: Path, plans: int, progress: "Progress") -> None:
    """Add the plans of a fleet to a store."""
    from benchmarks.stores.routes import routes  # noqa: PLC0415
    from storage.urls.opening import open_store  # noqa: PLC0415

    records = routes(plans, 1, data.parent, progress).records(0, plans, smooth=False)
    task = progress.add_task("plans", total=plans)
    with closing(open_store(f"sqlite://{data}/ppaas.sqlite")) as store:
        while batch := list(islice(records, AT_ONCE)):
            store.add_plans(batch)
            progress.advance(task, len(batch))


def _add_maps(data: Path, maps: int, progress: "Progress") -> None:
    """Publish maps: free space with obstacles everywhere, of which zstd makes a tenth."""
    import numpy as np  # noqa: PLC0415

    from ppaas.clock import epoch  # noqa: PLC0415
    from storage.records import Publication  # noqa: PLC0415
    from storage.urls.opening import open_map_store  # noqa: PLC0415

    store, rng = open_map_store(f"file://{data}/maps"), np.random.default_rng(1)
    task = progress.add_task("maps", total=maps)
    yaml = b"image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
    for number in range(maps):
        cells = np.where(rng.random((SIDE, SIDE), np.float32) < 0.02, 0, 254).astype(np.uint8)
        with store.stage() as upload:
            upload.add("yaml", [yaml])
            upload.add("image", [b"P5\n%d %d\n255\n" % (SIDE, SIDE), cells.tobytes()])
            store.publish(upload, Publication(f"map-{number}", "bench", epoch()))
        progress.advance(task)
