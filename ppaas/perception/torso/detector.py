"""Torso detector: finds people in depth images by the shape of head and shoulders.

An image takes five steps:

1. Its points are placed over the floor (`FloorView`).
2. Upright surfaces at the height of chests become proposals (`propose`).
3. The relief of each is sampled in metric cells (`patches_at`) and matched with templates, which give the height of the
   head (`UpperBody`). Proposals that look nothing like a person are left out.
4. Boosted trees distinguish people from what looks like them, by a finer relief and the width of the body at each
   height (`features_at`, `Trees`).
5. Of the proposals on one person, the best is kept.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.perception.kernels.depth import Depths
from ppaas.perception.torso.floor_view import FloorPoints, FloorView
from ppaas.perception.torso.models import Trees, UpperBody
from ppaas.perception.torso.parameters import TorsoDetectorParameters
from ppaas.perception.torso.patches import patches_at, propose
from ppaas.perception.torso.relief import features_at
from ppaas.perception.torso.trained import trained_templates, trained_trees

APART = 0.4
"""Least distance between two people [m]."""

NEAR = 0.2
"""Distance within which the best match of the templates stands for all [m]."""

LEAST_ODDS = -3.5
"""Least log odds of the templates for which the trees are asked."""

MOST_CANDIDATES = 64
"""Largest number of proposals of an image for which the trees are asked."""

DEPTH_OF_TORSO = 0.12
"""Distance from the front of a torso to its axis [m]."""

CHEST = 0.5
"""Distance of the centre of a torso below the top of the head [m]."""

ACROSS, AHEAD = 0.05, 0.08
"""Standard deviations of positions across and along the line of sight, without the noise of the camera [m]."""

NOISE = 1.425e-3
"""Standard deviation of the depth of Kinect-like cameras at 1 m, which grows with its square (Nguyen, Izadi and Lovell,
"Modeling Kinect sensor noise for improved 3D reconstruction and tracking", 3DIMPVT 2012) [1/m]."""


class TorsoDetection(NamedTuple):
    """A detected person, in the robot's frame on the floor.

    Parameters
    ----------
    x, y, z : float
        Centre of the torso [m].
    score : float
        Probability that it is a person, from 0 to 1.
    top : float
        Height of the head [m].
    covariance : list of float
        3 × 3 covariance matrix of the centre [m²], row-major.
    """

    x: float
    y: float
    z: float
    score: float
    top: float
    covariance: list[float]


class TorsoDetector:
    """Detector of people in the images of one camera.

    Parameters
    ----------
    view : FloorView
        View of the camera.
    parameters : TorsoDetectorParameters, optional
    templates : UpperBody, optional
    trees : Trees, optional
        By default the trained ones.
    """

    def __init__(
        self,
        view: FloorView,
        parameters: TorsoDetectorParameters | None = None,
        templates: UpperBody | None = None,
        trees: Trees | None = None,
    ) -> None:
        self._view = view
        self._parameters = parameters or TorsoDetectorParameters()
        self._templates = templates or trained_templates()
        self._trees = trees or trained_trees()

    @property
    def position(self) -> tuple[float, float]:
        """Position of the camera in the robot's frame [m]."""
        return float(self._view.origin[0]), float(self._view.origin[1])

    @property
    def yaw(self) -> float:
        """Direction of the optical axis in the robot's frame [rad]."""
        return math.atan2(self._view.rotation[1, 2], self._view.rotation[0, 2])

    @property
    def field_of_view(self) -> float:
        """Horizontal field of view [rad]."""
        camera = self._view.camera
        return math.atan(camera.cx / camera.fx) + math.atan((camera.width - 1 - camera.cx) / camera.fx)

    def detect(self, image: Depths) -> list[TorsoDetection]:
        """Return the people in an image, the surest first.

        Parameters
        ----------
        image : (height, width) uint16 or float32 array
            Depths in mm or m, respectively. A depth of 0, 65535 mm, or one that is not finite means that nothing was
            seen.

        Raises
        ------
        InvalidInput
            The image has another size or type than the camera's images.
        """
        own, view = self._parameters, self._view
        points = view.points(image)
        found = candidates(view, points, self._templates, own.range_min, own.range_max)
        if not len(found.places):
            return []
        odds = self._trees.odds(features_at(view, points, *found))
        kept = best_of(found.places, odds, log_odds(own.threshold), APART)
        return [self._detection(found.places[k], float(odds[k]), float(found.tops[k])) for k in kept]

    def _detection(self, place: NDArray[np.float32], odds: float, top: float) -> TorsoDetection:
        (ox, oy), (x, y) = self.position, place.tolist()
        distance = math.hypot(x - ox, y - oy)
        cos, sin = (x - ox) / distance, (y - oy) / distance
        noise = NOISE * distance * distance
        along, across = AHEAD**2 + noise**2, ACROSS**2 + (noise / distance) ** 2
        xx, yy, xy = (
            cos * cos * along + sin * sin * across,
            sin * sin * along + cos * cos * across,
            cos * sin * (along - across),
        )
        return TorsoDetection(
            x + DEPTH_OF_TORSO * cos, y + DEPTH_OF_TORSO * sin, top - CHEST,
            1.0 / (1.0 + math.exp(-min(max(odds, -50.0), 50.0))), top, [xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, along],
        )  # fmt: skip


class Candidates(NamedTuple):
    """Proposals that look like people.

    Parameters
    ----------
    places : (n, 2) float32 array
        Centres of the surfaces over the floor [m].
    tops : (n,) float32 array
        Heights of the tops of the heads [m].
    odds : (n,) float32 array
        Log odds of the templates.
    """

    places: NDArray[np.float32]
    tops: NDArray[np.float32]
    odds: NDArray[np.float32]


def candidates(
    view: FloorView, points: FloorPoints, templates: UpperBody, range_min: float, range_max: float
) -> Candidates:
    """Return the proposals that match a template, and better than others `NEAR`.

    Parameters
    ----------
    view : FloorView
        View of the camera.
    points : FloorPoints
        Points of its image.
    templates : UpperBody
    range_min, range_max : float
        Limits of the distance of torsos from the camera [m].
    """
    places = propose(view, points, range_min - DEPTH_OF_TORSO, range_max - DEPTH_OF_TORSO)
    if not len(places):
        return Candidates(places, np.empty(0, np.float32), np.empty(0, np.float32))
    match = templates.match(patches_at(view, points, places))
    kept = best_of(places, match.odds, LEAST_ODDS, NEAR)[:MOST_CANDIDATES]
    return Candidates(places[kept], match.top[kept], match.odds[kept])


def log_odds(chance: float) -> float:
    """Return the log odds of a probability from 0 to 1."""
    return math.log(chance / (1.0 - chance)) if 0.0 < chance < 1.0 else math.inf * (chance - 0.5)


def best_of(places: NDArray[np.float32], odds: NDArray[np.float32], least: float, apart: float) -> list[int]:
    """Return the indices of the places with the largest odds, the largest first, that are apart from each other.

    Parameters
    ----------
    places : (n, 2) array
        Places [m].
    odds : (n,) array
        Log odds of each.
    least : float
        Places with less are left out.
    apart : float
        Least distance between two [m].
    """
    kept: list[int] = []
    for k in np.argsort(-odds, kind="stable").tolist():
        if odds[k] < least:
            break
        if not kept or np.hypot(*(places[kept] - places[k]).T).min() > apart:
            kept.append(k)
    return kept
