"""Training of the torso detector on simulated scenes; writes its numbers as source texts.

``python -m benchmarks.people.torso.training ppaas/perception/torso`` takes an hour.
"""

import argparse
import base64
import math
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.people.torso.fitting import Fitted, Samples, boost, fit
from benchmarks.people.torso.scenes import CLUTTER, KINDS, DetectorScene, PersonTruth, scenes
from ppaas.perception.depth_scan import PinholeCamera
from ppaas.perception.torso.detector import DEPTH_OF_TORSO, candidates
from ppaas.perception.torso.floor_view import FloorView
from ppaas.perception.torso.models import Trees, UpperBody
from ppaas.perception.torso.patches import patches_at, propose
from ppaas.perception.torso.relief import FEATURES, features_at, mirrored
from robots.sim.bodies.furniture import COAT_STAND, POSTER
from robots.sim.depth.camera import DepthCameraModel

WIDTH = 112
"""Number of characters of a line."""

PROGRAM = "``python -m benchmarks.people.torso.training``"


def template_source(fitted: Fitted) -> str:
    """Return the source text of ``ppaas/perception/torso/template_weights.py``."""
    scales = [float(np.abs(weights).max()) / 127.0 for weights in fitted.weights]
    lines = [
        f'"""Weights of the templates, fitted by {PROGRAM}."""',
        "",
        f"SCALES = ({', '.join(f'{scale:.6g}' for scale in scales)})",
        '"""Value of one unit of the weights of each posture."""',
        "",
        f"BIASES = ({', '.join(f'{bias:.4f}' for bias in fitted.biases)})",
        '"""Bias of each posture."""',
        "",
        "WEIGHTS = (",
    ]
    for weights, scale in zip(fitted.weights, scales, strict=True):
        lines += ['    """', *_lines(np.rint(weights / scale).astype("i1"), "    "), '    """,']
    lines += [")", '"""Weights of each posture, int8 as base85, in the order of `template.SHAPE`."""', ""]
    return "\n".join(lines)


def tree_source(trees: Trees) -> str:
    """Return the source text of ``ppaas/perception/torso/tree_weights.py``."""
    scale = float(np.abs(trees.leaves).max()) / 127.0
    lines = [
        f'"""Trees that tell people from what looks like them, fitted by {PROGRAM}."""',
        "",
        f"BIAS = {trees.bias:.4f}",
        '"""Log odds without trees."""',
        "",
        f"SCALE = {scale:.6g}",
        '"""Value of one unit of the leaves."""',
    ]
    parts = {
        "FEATURES": (trees.features.astype("<u2"), "Feature of each decision, uint16, little-endian, as base85."),
        "LIMITS": (trees.limits, "Limit of each decision, uint8 as base85."),
        "LEAVES": (np.rint(trees.leaves / scale).astype("i1"), "Leaves, int8 as base85."),
    }
    for name, (numbers, text) in parts.items():
        lines += ["", f'{name} = """', *_lines(numbers), '"""', f'"""{text}"""']
    return "\n".join([*lines, ""])


def _lines(numbers: NDArray[np.generic], indent: str = "") -> list[str]:
    text = base64.b85encode(numbers.tobytes()).decode()
    return [indent + text[k : k + WIDTH] for k in range(0, len(text), WIDTH)]


ASIDE, IN_FRONT, BEHIND = 0.06, 0.3, 0.12
"""Distances from the axis of a torso at which proposals show the person, across and along the line of sight [m]."""

AWAY = 0.35
"""Distance from all people from which on proposals show nobody [m]."""

LEAST_SHARE = 0.35
"""Least visible share of a torso to learn from."""

ON = 0.15
"""Distance from the axis of a torso within which a candidate is the person [m]."""

HARD_KINDS = (*KINDS, COAT_STAND, COAT_STAND, POSTER)
"""Furniture to learn from, with more of what looks like people."""

CLUTTERED_KINDS = (*KINDS, COAT_STAND, *[CLUTTER] * 12)
"""Furniture of scenes with much clutter."""

REACH = (0.5, 7.0)
"""Distances of proposals [m]."""


def view_of(model: DepthCameraModel) -> FloorView:
    """Return the view of a simulated level camera."""
    (fx, fy), (cx, cy) = model.focal_lengths, model.centre
    return FloorView(PinholeCamera(model.width, model.height, fx, cx, cy), fy, mount_of(model))


def mount_of(model: DepthCameraModel) -> NDArray[np.float64]:
    """Return the transform from a simulated camera to the robot's frame, (4, 4)."""
    mount = np.eye(4)
    mount[:3, :3] = model.rotation.T
    mount[:3, 3] = model.x, model.y, model.z
    return mount


def samples_of(seen: Iterable[DetectorScene], model: DepthCameraModel) -> Samples:
    """Return the patches of scenes that show a person or nobody."""
    patches, tops = [], []
    for scene in seen:
        view = view_of(model)
        points = view.points(scene.image)
        places = propose(view, points, *REACH)
        if not len(places):
            continue
        labels = _labels(places.astype(np.float64), scene.people)
        used = np.isfinite(labels)
        patches.append(patches_at(view, points, places[used]))
        tops.append(labels[used])
    return Samples(np.concatenate(patches), np.concatenate(tops))


def _labels(places: NDArray[np.float64], people: list[PersonTruth]) -> NDArray[np.float64]:
    """Return the height of the head of the person at each place [m]; 0 for nobody, NaN where it is unclear."""
    tops = np.zeros(len(places))
    for person in people:
        distance = math.hypot(person.x, person.y)
        ahead = np.array((person.x, person.y)) / distance
        offset = places - np.array((person.x, person.y))
        along, across = offset @ ahead, offset @ np.array((-ahead[1], ahead[0]))
        tops[np.hypot(along, across) < AWAY] = np.nan
        on = (np.abs(across) < ASIDE) & (along > -IN_FRONT) & (along < BEHIND)
        if person.share >= LEAST_SHARE:
            tops[on] = person.top
    return tops


class TreeSamples(NamedTuple):
    """Features of candidates, (n, number of features) uint8, and whether each is a person, 1 or 0."""

    features: NDArray[np.uint8]
    labels: NDArray[np.float64]


def tree_samples_of(seen: Iterable[DetectorScene], model: DepthCameraModel, templates: UpperBody) -> TreeSamples:
    """Return the features of the candidates of scenes."""
    features, labels = [np.empty((0, FEATURES), np.uint8)], [np.empty(0)]
    for scene in seen:
        view = view_of(model)
        points = view.points(scene.image)
        found = candidates(view, points, templates, *REACH)
        if not len(found.places):
            continue
        people = _people_at(found.places.astype(np.float64), scene.people)
        used = np.isfinite(people)
        features.append(features_at(view, points, *found)[used])
        labels.append(people[used])
    return TreeSamples(np.concatenate(features), np.concatenate(labels))


def _people_at(places: NDArray[np.float64], people: list[PersonTruth]) -> NDArray[np.float64]:
    """Return 1 for each candidate that is on a person, 0 for nobody, and NaN where it is unclear."""
    axes = places * (1.0 + DEPTH_OF_TORSO / np.hypot(*places.T))[:, None]
    labels = np.zeros(len(places))
    for person in people:
        distance = np.hypot(*(axes - (person.x, person.y)).T)
        enough = person.share >= LEAST_SHARE
        labels[distance < (AWAY if enough else AWAY + 0.05)] = np.nan
        labels[(distance < ON) & enough] = 1.0
    return labels


def tilted(rng: np.random.Generator) -> DepthCameraModel:
    """Return a camera at a random height that looks up or down."""
    return DepthCameraModel(
        320, 240, z=float(rng.uniform(0.5, 1.6)), pitch=math.radians(float(rng.uniform(-15.0, 40.0)))
    )


def cluttered_samples(seed: int, worlds: int, images: int, templates: UpperBody) -> TreeSamples:
    """Return the features of candidates in scenes with much clutter, seen by cameras of any mount."""
    parts = [TreeSamples(np.empty((0, FEATURES), np.uint8), np.empty(0))]
    for k in range(worlds):
        model = tilted(np.random.default_rng((seed, k)))
        parts.append(
            tree_samples_of(scenes((seed + 1) * 10_000 + k, 1, images, model, CLUTTERED_KINDS), model, templates)
        )
    return TreeSamples(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def main() -> None:
    """Train, and write the source texts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder for the source texts, such as ppaas/perception/torso")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--worlds", type=int, default=600, help="for the trees; the templates take a fifteenth")
    parser.add_argument("--images", type=int, default=40, help="on each world")
    given = parser.parse_args()
    model = DepthCameraModel(320, 240)
    fitted = fit(samples_of(scenes(given.seed, given.worlds // 15, given.images, model), model))
    (given.folder / "template_weights.py").write_text(template_source(fitted))
    seen = scenes(given.seed + 1, given.worlds, given.images, model, HARD_KINDS)
    level = tree_samples_of(seen, model, fitted.templates())
    other = cluttered_samples(given.seed, given.worlds // 3, given.images * 5 // 8, fitted.templates())
    features = np.concatenate([level.features, other.features])
    labels = np.concatenate([level.labels, other.labels])
    trees = boost(np.concatenate([features, mirrored(features)]), np.tile(labels, 2))
    (given.folder / "tree_weights.py").write_text(tree_source(trees))


if __name__ == "__main__":
    main()
