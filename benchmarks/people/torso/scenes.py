"""Scenes for the torso detector: people and furniture at random in the view of a camera on a simulated map.

A person *counts* if at least half of the torso is in the image, not hidden, and not in the shadow of the camera's
projector; a person of whom less is visible may be detected or not.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.free_space import distance_to_occupied
from ppaas.maps.generate import office, warehouse
from ppaas.maps.grid import OCCUPIED_THRESHOLD, GridMap
from ppaas.maps.raycast import cast_rays
from robots.sim.bodies import furniture as pieces
from robots.sim.bodies.body import SHOULDER, Stance, body_shapes, head_height, random_body
from robots.sim.bodies.furniture import Furniture
from robots.sim.depth.camera import DepthCamera, DepthCameraModel, DepthImage, Scene
from robots.sim.depth.shapes import Shapes, box, capsule, ellipsoid, joined, shapes_of

Floats = NDArray[np.float64]

CLUTTER = "clutter"
"""Kind of furniture that is a heap of boxes, balls and rods, of up to the size of a person."""

KINDS = (pieces.CHAIR, pieces.TABLE, pieces.COAT_STAND, pieces.COLUMN, pieces.POSTER)
"""Kinds of furniture in scenes."""

CLEARANCE = 0.35
"""Least distance of people and cameras from walls [m]."""

NEAREST, FARTHEST = 0.7, 7.0
"""Distances of people and furniture from the camera [m]."""

OUTLOOK = 2.5
"""Least distance of walls ahead of the camera [m]."""

SIDE_BY_SIDE = 0.55
"""Distance between two people who stand side by side [m]."""

TORSO_ROWS, TORSO_COLUMNS, TORSO_HEIGHT, TORSO_WIDTH = 7, 5, 0.45, 0.24
"""Points that stand for a torso, and the size of their grid below the shoulders [m]."""


@dataclass(frozen=True, slots=True)
class PersonTruth:
    """A person in the robot's frame.

    Parameters
    ----------
    x, y : float
        Axis of the torso [m].
    top : float
        Height of the head [m].
    share : float
        Share of the torso that is visible.
    sitting : bool
    """

    x: float
    y: float
    top: float
    share: float
    sitting: bool


@dataclass(frozen=True, slots=True)
class DetectorScene:
    """An image and its truth.

    Parameters
    ----------
    image : (height, width) uint16 array
        Depths [mm].
    people : list of PersonTruth
    furniture : list of tuple
        Kind and position of each piece in the robot's frame [m].
    """

    image: DepthImage
    people: list[PersonTruth]
    furniture: list[tuple[str, float, float]]


@dataclass(slots=True)
class _Placed:
    """People and furniture placed so far: positions with the radius of each [m], and shapes."""

    spots: list[tuple[float, float, float]] = field(default_factory=list)
    bodies: list[tuple[Shapes, Pose2D, float, float, bool]] = field(default_factory=list)
    furniture: list[Furniture] = field(default_factory=list)

    def free(self, x: float, y: float, radius: float) -> bool:
        return all(math.hypot(x - a, y - b) >= radius + other for a, b, other in self.spots)


class SceneGenerator:
    """Generator of scenes on one map.

    Parameters
    ----------
    grid : GridMap
        The map.
    model : DepthCameraModel
        The camera.
    rng : numpy.random.Generator
        Random source.
    kinds : sequence of str
        Kinds of furniture to draw from.
    """

    def __init__(
        self, grid: GridMap, model: DepthCameraModel, rng: np.random.Generator, kinds: Sequence[str] = KINDS
    ) -> None:
        self._grid, self._model, self._rng, self._kinds = grid, model, rng, kinds
        self._occupied = grid.data >= OCCUPIED_THRESHOLD
        self._clearance = distance_to_occupied(grid)
        self._camera = DepthCamera(self._occupied, grid.info, model, rng)
        self._free = np.argwhere(self._clearance >= CLEARANCE)

    def scene(self, most_people: int = 5, most_furniture: int = 5) -> DetectorScene:
        """Return a scene with up to so many people and pieces of furniture."""
        rng = self._rng
        eye = self._eye()
        placed = _Placed()
        for _ in range(int(rng.integers(most_people + 1))):
            self._add_person(eye, placed)
        for _ in range(int(rng.integers(most_furniture + 1))):
            self._add_furniture(eye, placed)
        shapes = joined([*(body[0] for body in placed.bodies), *(piece.shapes for piece in placed.furniture)])
        mirrors = tuple(piece.mirror for piece in placed.furniture if piece.mirror is not None)
        whole = Scene(shapes, mirrors)
        image = self._camera.measure(eye, whole)
        depths = self._camera.inverse_depths(eye, whole).copy()
        depths[image == 0] = np.inf
        people = [self._truth(eye, body, depths) for body in placed.bodies]
        back = eye.inverse()
        kinds = [(piece.kind, *(back @ piece.pose)[:2]) for piece in placed.furniture]
        return DetectorScene(image, people, kinds)

    def _eye(self) -> Pose2D:
        """Return a free pose from which the camera does not look at a wall right ahead, if one is found."""
        for _ in range(20):
            x, y = self._grid.info.to_world(self._free[self._rng.integers(len(self._free))]).tolist()
            eye = Pose2D(x, y, float(self._rng.uniform(-math.pi, math.pi)))
            if not cast_rays(self._occupied, self._grid.info, eye, np.zeros(1), FARTHEST)[0] < OUTLOOK:
                break
        return eye

    # -- people --------------------------------------------------------------------------------------------------------

    def _add_person(self, eye: Pose2D, placed: _Placed) -> None:
        rng = self._rng
        spot = self._spot(eye, placed, 0.3)
        if spot is None:
            return
        facing = float(rng.uniform(-math.pi, math.pi))
        if rng.random() < 0.25:
            self._add_body(Pose2D(*spot, facing), placed, sitting=True)
            placed.furniture.append(pieces.chair(Pose2D(*spot, facing)))
            return
        self._add_body(Pose2D(*spot, facing), placed, sitting=False)
        if rng.random() < 0.25:
            side = float(rng.uniform(-math.pi, math.pi))
            x, y = spot[0] + SIDE_BY_SIDE * math.cos(side), spot[1] + SIDE_BY_SIDE * math.sin(side)
            if self._open(eye, x, y):
                self._add_body(Pose2D(x, y, float(rng.uniform(-math.pi, math.pi))), placed, sitting=False)

    def _add_body(self, pose: Pose2D, placed: _Placed, *, sitting: bool) -> None:
        rng = self._rng
        body = random_body(rng)
        walking = not sitting and rng.random() < 0.5
        stance = Stance(
            stride=float(rng.uniform(0.22, 0.45)) if walking else 0.0, phase=float(rng.uniform(0.0, 2.0 * math.pi)),
            sitting=sitting,
        )  # fmt: skip
        top = head_height(body, stance)
        shoulder = top - (1.0 - SHOULDER) * body.height
        placed.bodies.append((body_shapes(body, stance, pose), pose, top, shoulder, sitting))
        placed.spots.append((pose.x, pose.y, 0.25))

    def _truth(self, eye: Pose2D, body: tuple[Shapes, Pose2D, float, float, bool], depths: Floats) -> PersonTruth:
        shapes, pose, top, shoulder, sitting = body
        x, y, _ = eye.inverse() @ pose
        alone = self._camera.inverse_depths(eye, Scene(shapes, wall_height=0.0))
        return PersonTruth(x, y, top, self._share((x, y), shoulder, alone, depths), sitting)

    def _share(self, at: tuple[float, float], shoulder: float, alone: Floats, depths: Floats) -> float:
        """Return the share of the points of a torso that are in the image and not hidden.

        ``depths`` are the inverse depths of the scene, infinite without a reading; ``alone`` those without all others.
        """
        model, distance = self._model, math.hypot(*at)
        if at[0] < 0.3:
            return 0.0
        z, across = np.meshgrid(
            shoulder - np.linspace(0.0, 1.0, TORSO_ROWS) * TORSO_HEIGHT,
            np.linspace(-0.5, 0.5, TORSO_COLUMNS) * TORSO_WIDTH,
            indexing="ij",
        )
        points = np.stack((at[0] - at[1] / distance * across, at[1] + at[0] / distance * across, z), axis=2)
        right, down, ahead = model.rotation @ (points - (model.x, model.y, model.z)).reshape(-1, 3).T
        (fx, fy), (cx, cy) = model.focal_lengths, model.centre
        columns, rows = (
            np.rint(centre + focal * part / np.maximum(ahead, 0.1)).astype(int).reshape(z.shape)
            for centre, focal, part in ((cx, fx, right), (cy, fy, down))
        )
        inside = (columns >= 0) & (columns < model.width) & (rows >= 0) & (rows < model.height)
        shown = np.zeros(inside.shape, bool)
        pixel = rows[inside], columns[inside]
        shown[inside] = np.abs(alone[pixel] - depths[pixel]) < 1e-9
        return float(shown.mean())

    # -- furniture -----------------------------------------------------------------------------------------------------

    def _add_furniture(self, eye: Pose2D, placed: _Placed) -> None:
        rng = self._rng
        kind = rng.choice(self._kinds)
        if kind == pieces.POSTER:
            placed.furniture += self._poster(eye)
            return
        spot = self._spot(eye, placed, 0.35)
        if spot is None:
            return
        pose = Pose2D(*spot, float(rng.uniform(-math.pi, math.pi)))
        if kind == pieces.CHAIR:
            piece = pieces.chair(pose)
        elif kind == pieces.TABLE:
            piece = pieces.table(pose, float(rng.uniform(0.8, 1.8)), float(rng.uniform(0.6, 0.9)))
        elif kind == pieces.COAT_STAND:
            piece = pieces.coat_stand(pose, hat=bool(rng.random() < 0.4))
        elif kind == CLUTTER:
            piece = Furniture(CLUTTER, pose, clutter(rng).placed(pose))
        else:
            piece = pieces.column(pose, float(rng.uniform(0.1, 0.3)))
        placed.furniture.append(piece)
        placed.spots.append((*spot, 0.3))

    def _poster(self, eye: Pose2D) -> list[Furniture]:
        """Return a poster on the wall in a random direction, if one is near."""
        bearing = float(self._rng.uniform(-0.45, 0.45))
        distance = float(cast_rays(self._occupied, self._grid.info, eye, np.array([bearing]), FARTHEST)[0])
        if not 1.0 < distance < FARTHEST - 0.5:
            return []
        angle = eye.theta + bearing
        along_x = abs(math.cos(angle)) > abs(math.sin(angle))
        facing = math.atan2(0.0, -math.cos(angle)) if along_x else math.atan2(-math.sin(angle), 0.0)
        x, y = eye.x + (distance - 0.03) * math.cos(angle), eye.y + (distance - 0.03) * math.sin(angle)
        return [pieces.poster(Pose2D(x, y, facing))]

    # -- places --------------------------------------------------------------------------------------------------------

    def _spot(self, eye: Pose2D, placed: _Placed, radius: float) -> tuple[float, float] | None:
        """Return a place in the view that is free; None if none is found."""
        for _ in range(30):
            distance = float(self._rng.uniform(NEAREST, FARTHEST))
            angle = eye.theta + float(self._rng.uniform(-0.58, 0.58))
            x, y = eye.x + distance * math.cos(angle), eye.y + distance * math.sin(angle)
            if self._open(eye, x, y) and placed.free(x, y, radius):
                return x, y
        return None

    def _open(self, eye: Pose2D, x: float, y: float) -> bool:
        """Return whether a place is away from walls, which do not hide it."""
        cell = self._grid.info.cell_of(x, y)
        if cell is None or self._clearance[cell] < CLEARANCE:
            return False
        bearing = math.atan2(y - eye.y, x - eye.x) - eye.theta
        seen = cast_rays(self._occupied, self._grid.info, eye, np.array([bearing]), 2.0 * FARTHEST)[0]
        return math.hypot(x - eye.x, y - eye.y) < seen or bool(np.isnan(seen))


def clutter(rng: np.random.Generator) -> Shapes:
    """Return a heap of boxes, balls and rods, in its own frame."""
    capsules, solids = [], []
    highest = float(rng.uniform(0.6, 2.0))
    for _ in range(int(rng.integers(2, 12))):
        (x, y), z = rng.normal(0.0, 0.25, 2).tolist(), float(rng.uniform(0.0, highest))
        half = rng.uniform(0.03, 0.35, 3).tolist()
        yaw = float(rng.uniform(0.0, math.pi))
        shape = rng.integers(4)
        if shape < 2:
            solids.append(box((x, y, z), (half[0], half[1], half[2]), yaw))
        elif shape < 3:
            solids.append(ellipsoid((x, y, z), (half[0], half[1], half[2]), yaw))
        else:
            lean = rng.normal(0.0, 0.1, 2).tolist()
            capsules.append(
                capsule((x, y, max(z - half[0], 0.0)), (x + lean[0], y + lean[1], z + half[0]), half[1] / 3)
            )
    return shapes_of(capsules, solids)


def scenes(
    seed: int, worlds: int, images: int, model: DepthCameraModel | None = None, kinds: Sequence[str] = KINDS
) -> Iterator[DetectorScene]:
    """Yield scenes on offices and warehouses, as many images on each of so many worlds.

    Parameters
    ----------
    seed : int
        Seed of worlds and scenes.
    worlds, images : int
        Number of worlds, and of images of each.
    model : DepthCameraModel, optional
        The camera; by default one of 640 × 480 pixels, level and 1 m above the floor.
    kinds : sequence of str
        Kinds of furniture to draw from.
    """
    rng = np.random.default_rng(seed)
    for k in range(worlds):
        grid = (office, warehouse)[k % 2](seed=int(rng.integers(1 << 30)))
        generator = SceneGenerator(grid, model or DepthCameraModel(), rng, kinds)
        for _ in range(images):
            yield generator.scene()
