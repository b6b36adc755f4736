"""Part ``detector`` of ``ppaas bench people``: precision, recall and time of the torso detector.

Scenes are simulated with seeds that the detector was not trained with. Recorded images show an office without people,
so whatever is detected in them is wrong.
"""

import statistics
import time
from typing import Any

import numpy as np

from benchmarks.harness.figures import Figure, PartResult, median_of
from benchmarks.people.options import PeopleOptions
from benchmarks.people.torso.recorded import recorded_images
from benchmarks.people.torso.scenes import scenes
from benchmarks.people.torso.score import DetectorScore
from benchmarks.people.torso.training import view_of
from ppaas.perception.torso.detector import TorsoDetection, TorsoDetector
from ppaas.perception.torso.floor_view import FloorView
from robots.sim.depth.camera import DepthCameraModel

PART = "detector"

FIRST_SEED = 1_000_000
"""Seed of the first scenes; training has smaller ones."""

WORLDS, IMAGES, QUICK_WORLDS = 50, 40, 4
"""Number of worlds, of images of each, and of worlds if few samples are taken."""

LEAST, MOST_MS = 0.97, 8.0
"""Bars of precision and recall, and of the time of an image [ms]."""

SIZES = ((640, 480), (320, 240))
"""Sizes of images; the bars hold for the first."""


def measure(options: PeopleOptions) -> PartResult:
    """Return the figures of simulated images, and of those in the folder ``depth`` of the data, if it is given."""
    figures, rows, results = list[Figure](), list[dict[str, str]](), list[dict[str, Any]]()
    for size in SIZES:
        score, seconds = _simulated(options, size)
        figures += _figures(score, seconds, size)
        rows.append(_row(score, size))
        results.append(_result(score, seconds, size))
    if options.data is not None:
        wrong, images = _recorded(options)
        note = f"{images} images of an office without people"
        figures.append(
            Figure(PART, "detections of nobody in a recorded image", round(wrong / images, 4), "", note=note)
        )
        results.append({"recorded_images": images, "wrong": wrong})
    return PartResult(figures, rows, results)


def _simulated(options: PeopleOptions, size: tuple[int, int]) -> tuple[DetectorScore, list[float]]:
    """Return the score, and the CPU time of each image [s]."""
    score, seconds = DetectorScore(), list[float]()
    model = DepthCameraModel(*size)
    worlds = QUICK_WORLDS if options.quick else WORLDS
    TorsoDetector(view_of(model)).detect(np.zeros((size[1], size[0]), np.uint16))
    for scene in scenes(FIRST_SEED + options.seed, worlds, IMAGES, model):
        detector = TorsoDetector(view_of(model))
        found, took = _timed(detector, scene.image)
        seconds.append(took)
        score.add(scene, found)
    return score, seconds


def _timed(
    detector: TorsoDetector, image: "np.ndarray[Any, np.dtype[np.uint16]]"
) -> tuple[list[TorsoDetection], float]:
    # The CPU time of all threads: what the image takes on one core, whatever else runs on this computer.
    start = time.process_time()
    found = detector.detect(image)
    return found, time.process_time() - start


def _recorded(options: PeopleOptions) -> tuple[int, int]:
    """Return the number of detections in recorded images, and that of the images."""
    assert options.data is not None
    wrong = images = 0
    for image, camera, mount in recorded_images(options.data / "depth"):
        wrong += len(TorsoDetector(FloorView(camera, camera.fx, mount)).detect(image))
        images += 1
    return wrong, images


def _figures(score: DetectorScore, seconds: list[float], size: tuple[int, int]) -> list[Figure]:
    name, barred = f"{size[0]}×{size[1]}", size == SIZES[0]
    note = f"{score.found + score.missed} people at 1–5 m, half of the torso visible or more"
    bar = LEAST if barred else None
    return [
        Figure(PART, f"precision, {name}", round(score.precision, 4), "", limit=bar, floor=True,
               note=f"{score.wrong} wrong of {score.found + score.wrong} detections"),
        Figure(PART, f"recall, {name}", round(score.recall, 4), "", limit=bar, floor=True, note=note),
        median_of(PART, f"CPU time of an image, {name}", seconds, limit=MOST_MS if barred else None),
        median_of(PART, f"error of positions, {name}", score.errors, "m"),
    ]  # fmt: skip


def _row(score: DetectorScore, size: tuple[int, int]) -> dict[str, str]:
    kinds = ("chair", "table", "coat_stand", "column", "poster", "wall", "person")
    missed = ", ".join(f"{count} {kind}" for kind, count in score.missed_kinds.most_common(4))
    return {
        "size": f"{size[0]}×{size[1]}",
        **{f"taken for a person: {kind.replace('_', ' ')}": str(score.mistaken[kind]) for kind in kinds},
        "missed": missed or "none",
    }


def _result(score: DetectorScore, seconds: list[float], size: tuple[int, int]) -> dict[str, Any]:
    return {
        "size": list(size), "found": score.found, "missed": score.missed, "wrong": score.wrong,
        "precision": score.precision, "recall": score.recall, "mistaken": dict(score.mistaken),
        "missed_kinds": dict(score.missed_kinds), "milliseconds_median": 1e3 * statistics.median(seconds),
        "milliseconds_p99": 1e3 * float(np.quantile(seconds, 0.99)),
        "error_mean": statistics.mean(score.errors) if score.errors else None,
    }  # fmt: skip
