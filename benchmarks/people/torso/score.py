"""Score of detections: precision, recall and error of positions, and kinds of wrong detections."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from benchmarks.people.torso.scenes import DetectorScene, PersonTruth
from ppaas.perception.torso.detector import TorsoDetection

NEAREST, FARTHEST = 1.0, 5.0
"""Distances at which people and detections count [m]."""

HALF = 0.5
"""Least visible share of the torso of a person who counts."""

GATE = 0.4
"""Largest distance of a detection from its person [m]."""

PERSON, WALL = "person", "wall"
"""Kinds of wrong detections beside furniture: a second detection of a person, and anything else."""

AT = 0.6
"""Distance from the nearest piece of furniture within which a detection is on it [m]."""


@dataclass
class DetectorScore:
    """Sums over images.

    Attributes
    ----------
    found, missed, wrong : int
        Numbers of people who were found and missed, and of detections of nobody.
    errors : list of float
        Distances between people and their detections [m].
    mistaken : Counter
        Number of wrong detections by what they were.
    missed_kinds : Counter
        Number of missed people by posture and distance.
    """

    found: int = 0
    missed: int = 0
    wrong: int = 0
    errors: list[float] = field(default_factory=list)
    mistaken: Counter[str] = field(default_factory=Counter)
    missed_kinds: Counter[str] = field(default_factory=Counter)

    @property
    def precision(self) -> float:
        """Share of detections that are people."""
        return self.found / max(self.found + self.wrong, 1)

    @property
    def recall(self) -> float:
        """Share of people who are detected."""
        return self.found / max(self.found + self.missed, 1)

    def add(self, scene: DetectorScene, detections: Sequence[TorsoDetection]) -> None:
        """Add the detections in an image. People of whom less than half is visible neither count nor are wrong."""
        matched = _matched(scene.people, detections)
        for k, person in enumerate(scene.people):
            if not (NEAREST <= math.hypot(person.x, person.y) <= FARTHEST and person.share >= HALF):
                continue
            if k in matched:
                self.found += 1
                self.errors.append(matched[k][1])
            else:
                self.missed += 1
                posture = "sits" if person.sitting else "stands"
                self.missed_kinds[f"{posture} at {math.hypot(person.x, person.y):.0f} m"] += 1
        used = {detection for detection, _ in matched.values()}
        for i, detection in enumerate(detections):
            if i not in used and NEAREST <= math.hypot(detection.x, detection.y) <= FARTHEST:
                self.wrong += 1
                self.mistaken[_kind_at(scene, detection)] += 1


def _matched(people: list[PersonTruth], detections: Sequence[TorsoDetection]) -> dict[int, tuple[int, float]]:
    """Return the detection of each person who has one with its distance [m], assigned greedily, the nearest first."""
    pairs = sorted(
        (math.hypot(detection.x - person.x, detection.y - person.y), i, k)
        for i, detection in enumerate(detections)
        for k, person in enumerate(people)
    )
    matched: dict[int, tuple[int, float]] = {}
    used = set[int]()
    for distance, i, k in pairs:
        if distance <= GATE and i not in used and k not in matched:
            used.add(i)
            matched[k] = i, distance
    return matched


def _kind_at(scene: DetectorScene, detection: TorsoDetection) -> str:
    near = [(math.hypot(detection.x - person.x, detection.y - person.y), PERSON) for person in scene.people]
    near += [(math.hypot(detection.x - x, detection.y - y), kind) for kind, x, y in scene.furniture]
    distance, kind = min(near, default=(math.inf, WALL))
    return kind if distance <= AT else WALL
