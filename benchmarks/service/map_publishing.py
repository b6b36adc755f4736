"""Time to publish and fetch a map of 8192 × 8192 cells over REST, compared with copying its file."""

import asyncio
import os
import shutil
import statistics
import tempfile
from collections.abc import Sequence
from pathlib import Path

from rich.progress import Progress

from benchmarks.harness.cloud_under_test import Target
from benchmarks.harness.figures import Figure, median_of
from ppaas.clock import monotonic
from robots.client.rest_paths import path_of

PART = "maps"
SIDE, QUICK_SIDE = 8192, 1024
RUNS, QUICK = 7, 2
RATIO_LIMIT = 2.0
YAML = b"image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"
MAP = "bench-large"


async def measure(target: Target, progress: Progress, quick: bool) -> list[Figure]:
    """Copy the file and publish it in turns, each time with other cells, so that the cloud must store it."""
    side = QUICK_SIDE if quick else SIDE
    copied, synced, published, fetched = [], [], [], []
    with tempfile.TemporaryDirectory(prefix="ppaas-bench-") as name:
        folder = Path(name)
        image = folder / "map.pgm"
        for run in progress.track(range(QUICK if quick else RUNS), description=f"a map of {side}²"):
            await asyncio.to_thread(_write, image, side, run)
            copied.append(await asyncio.to_thread(_copy, image, folder / f"copy-{run}", sync=False))
            synced.append(await asyncio.to_thread(_copy, image, folder / f"synced-{run}", sync=True))
            await asyncio.to_thread(os.sync)
            began = monotonic()
            await target.rest.upload_map(MAP, YAML, image)
            published.append(monotonic() - began)
            began = monotonic()
            await target.rest.fetch_to(path_of("maps", MAP, "image"), folder / "fetched")
            fetched.append(monotonic() - began)
    await target.rest.delete(path_of("maps", MAP))
    return _figures(side, copied, synced, published, fetched)


def _figures(side: int, *samples: Sequence[float]) -> list[Figure]:
    copied, synced, published, fetched = samples
    ratios = [ours / copy for ours, copy in zip(published, synced, strict=True)]
    ratio = statistics.median(ratios)
    return [
        median_of(PART, f"publish {side}²", published, note="over REST: sent, hashed, checked, synced"),
        median_of(PART, f"fetch {side}²", fetched, note="over REST: proved to be what was published"),
        median_of(PART, "copy the file", copied, yardstick=True, note="into the page cache"),
        median_of(PART, "copy the file, synced", synced, yardstick=True, note="as lasting as a map that is published"),
        Figure(
            PART,
            "publish over copy, synced",
            round(ratio, 2),
            "×",
            round(min(ratios), 2),
            round(max(ratios), 2),
            RATIO_LIMIT,
            note="run by run",
        ),
    ]


def _write(path: Path, side: int, run: int) -> None:
    row = bytes([run]) + b"\xfe" * (side - 1)
    with path.open("wb") as file:
        file.write(b"P5\n%d %d\n255\n" % (side, side))
        for _ in range(side):
            file.write(row)


def _copy(source: Path, target: Path, *, sync: bool) -> float:
    """Copy a file to a new one, as a new map version is written; return the time [s]."""
    os.sync()  # exclude earlier writes of other processes
    began = monotonic()
    shutil.copyfile(source, target)
    if sync:
        with target.open("rb") as file:
            os.fsync(file.fileno())
    return monotonic() - began
