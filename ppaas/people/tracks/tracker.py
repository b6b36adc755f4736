"""Tracker of the people that the detectors of one robot see; it keeps their ids through gaps."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ppaas.people.tracks.assignment import assign
from ppaas.people.tracks.filter_bank import MODELS, FilterBank, MotionParameters, inverse_2x2
from ppaas.people.tracks.hungarian import least_cost

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Detection:
    """A person in one measurement, in a frame that does not move.

    Parameters
    ----------
    x, y : float
        Position [m].
    covariance : (xx, xy, yy)
        Covariance of the position [m²].
    score : float
        Score of the detector, from 0 to 1.
    begins : bool
        Whether it may begin a track.
    believed : int
        Id of the track that it is by the ids of a detector that tracks people itself; 0 if it has none. It decides
        between tracks that are near enough, so that an id which the detector reuses does no harm.
    z : float
        Height above the floor, 0 if it is unknown: lasers do not measure it [m].
    id : str
        Id that the detector keeps for the person; empty if it tracks nobody.
    """

    x: float
    y: float
    covariance: tuple[float, float, float] = (0.01, 0.0, 0.01)
    score: float = 0.9
    begins: bool = True
    believed: int = 0
    z: float = 0.0
    id: str = ""


@dataclass(slots=True)
class LocalTrack:
    """A tracked person.

    Parameters
    ----------
    id : int
        From 1; it is not reused.
    first_seen, last_seen : float
        Times of the first and the last detection [s].
    evidence : float
        Logarithm of the odds that it is a person.
    score : float
        Mean of the scores of its detections, of which the newest count most.
    confirmed : bool
        Whether the evidence has been enough once.
    x, y, vx, vy : float
        State [m, m/s].
    covariance : (xx, xy, yy)
        Covariance of the position [m²].
    z : float
        Last known height above the floor, 0 if there is none [m].
    """

    id: int
    first_seen: float
    last_seen: float
    evidence: float
    score: float
    confirmed: bool = False
    x: float = 0.0
    y: float = 0.0
    vx: float = 0.0
    vy: float = 0.0
    covariance: tuple[float, float, float] = (0.0, 0.0, 0.0)
    z: float = 0.0


@dataclass(frozen=True, slots=True)
class TrackerState:
    """State of a tracker, for checkpoints.

    Parameters
    ----------
    at : float or None
        Time of the last step [s]; None before it.
    next : int
        Id of the next track.
    tracks : list of LocalTrack
    means, covariances, weights : list
        Arrays of `FilterBank`.
    """

    at: float | None
    next: int
    tracks: list[LocalTrack]
    means: list[list[list[float]]]
    covariances: list[list[list[list[float]]]]
    weights: list[list[float]]


@dataclass(frozen=True, slots=True)
class TrackerParameters:
    """Parameters of a tracker.

    Parameters
    ----------
    gate : float
        Squared Mahalanobis distance within which a detection can be a track: 99.7 % of a person's own.
    farthest : float
        Largest distance between a detection and the predicted position [m].
    confirmed_at : float
        Evidence from which a track counts as a person: one detection of score 0.9, or several weaker ones.
    most_evidence : float
        Limit of the evidence: it decides how many misses a track survives.
    detected : float
        Probability that a person in view is detected.
    forget_after : float
        Time without a detection after which a track is deleted [s].
    closest : float
        Distance to a track within which no other is begun, and two tracks may be one person [m].
    joined_after : float
        Time for which two tracks are that close, and never detected at once, until the younger is deleted [s].
    motion : MotionParameters
    """

    gate: float = 11.6
    farthest: float = 1.2
    confirmed_at: float = 2.0
    most_evidence: float = 5.0
    detected: float = 0.6
    forget_after: float = 4.0
    closest: float = 0.3
    joined_after: float = 1.0
    motion: MotionParameters = field(default_factory=MotionParameters)


BELIEVED = 0.2
"""Factor of the cost of a pair of track and detection that a detector's own ids confirm."""

Expected = Callable[[LocalTrack], bool]


def always(_: LocalTrack) -> bool:
    """Return that a track should have been detected: the default."""
    return True


class PeopleTracker:
    """Tracks of people, which measurements update one after another.

    Parameters
    ----------
    parameters : TrackerParameters

    Attributes
    ----------
    tracks : list of LocalTrack
        At the time of the last step; also those that are not confirmed yet.
    at : float
        That time [s].
    assigned : list of int
        Id of the track of each detection of the last step; 0 for a detection without one.
    """

    def __init__(self, parameters: TrackerParameters | None = None) -> None:
        self.parameters = TrackerParameters() if parameters is None else parameters
        self.tracks: list[LocalTrack] = []
        self.at = -math.inf
        self.assigned: list[int] = []
        self._bank = FilterBank(self.parameters.motion)
        self._next = 1
        self._near_since: dict[tuple[int, int], float] = {}

    @property
    def people(self) -> list[LocalTrack]:
        """The tracks that are confirmed."""
        return [track for track in self.tracks if track.confirmed]

    def state(self) -> TrackerState:
        """Return all that `restore` needs to go on."""
        bank = self._bank
        at = self.at if math.isfinite(self.at) else None
        arrays = bank.means.tolist(), bank.covariances.tolist(), bank.weights.tolist()
        return TrackerState(at, self._next, [replace(track) for track in self.tracks], *arrays)

    def restore(self, state: TrackerState) -> None:
        """Go on from a state."""
        count = len(state.tracks)
        self.at, self._next = -math.inf if state.at is None else state.at, state.next
        self.tracks = [replace(track) for track in state.tracks]
        self._bank.means = np.array(state.means).reshape(count, MODELS, 4)
        self._bank.covariances = np.array(state.covariances).reshape(count, MODELS, 4, 4)
        self._bank.weights = np.array(state.weights).reshape(count, MODELS)

    def predict(self, now: float) -> None:
        """Predict the tracks until a time [s]; an earlier time than the last changes nothing."""
        self._bank.predict(now - self.at if math.isfinite(self.at) else 0.0)
        self.at = max(now, self.at)
        self._read()

    def step(self, now: float, detections: Sequence[Detection], expected: Expected = always) -> None:
        """Predict the tracks until a measurement, and update them by its detections.

        Parameters
        ----------
        now : float
            Time of the measurement [s].
        detections : sequence of Detection
            All that this detector found.
        expected : callable
            Called with a track that was not detected; whether it should have been, since it is in the detector's view
            and nothing hides it. Other tracks are predicted without doubt.
        """
        self.predict(now)
        positions, spreads = _arrays(detections)
        costs = self._costs(positions, spreads)
        self._favour_believed(costs, detections)
        limit = 1.0 + float(np.max(costs, initial=0.0, where=np.isfinite(costs)))
        rows, columns = assign(costs, limit, least_cost)
        self.assigned = [0] * len(detections)
        self._bank.update(rows, positions[columns], spreads[columns])
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            self._confirm(self.tracks[row], detections[column])
            self.assigned[column] = self.tracks[row].id
        missed = set(range(len(self.tracks))) - set(rows.tolist())
        self._miss([self.tracks[row] for row in sorted(missed)], expected)
        self._begin([(k, each) for k, each in enumerate(detections) if k not in set(columns.tolist())], spreads)
        self._join(set(self.assigned))
        self._forget()
        self._read()

    def _costs(self, positions: Array, spreads: Array) -> Array:
        """Return the (n, m) costs of taking a detection for a track, infinite where they are too far apart.

        A cost is the squared Mahalanobis distance, plus the logarithm of how much larger the area is in which the track
        may be than the detection's area: so the detection of a person in sight is not taken for a hidden one.
        """
        mean, covariance = self._bank.states()
        off = positions[np.newaxis] - mean[:, np.newaxis, :2]
        inverse, area = inverse_2x2(covariance[:, np.newaxis, :2, :2] + spreads[np.newaxis])
        distances = np.einsum("nmi,nmij,nmj->nm", off, inverse, off)
        _, least = inverse_2x2(spreads)
        far = (np.hypot(off[..., 0], off[..., 1]) > self.parameters.farthest) | (distances >= self.parameters.gate)
        return np.where(far, np.inf, distances + np.log(area / least))

    def _favour_believed(self, costs: Array, detections: Sequence[Detection]) -> None:
        """Lower the cost of the pairs that a detector believes in, in place."""
        if not any(each.believed for each in detections):
            return
        ids = np.array([track.id for track in self.tracks])
        believed = np.array([each.believed for each in detections])
        costs[ids[:, np.newaxis] == believed] *= BELIEVED

    def _confirm(self, track: LocalTrack, detection: Detection) -> None:
        track.evidence = min(track.evidence + _evidence(detection.score), self.parameters.most_evidence)
        track.score += 0.3 * (detection.score - track.score)
        track.confirmed |= track.evidence >= self.parameters.confirmed_at
        track.last_seen = self.at
        track.z = detection.z or track.z

    def _miss(self, tracks: list[LocalTrack], expected: Expected) -> None:
        loss = math.log(1.0 - self.parameters.detected)
        for track in tracks:
            if expected(track):
                track.evidence += loss

    def _begin(self, unknown: list[tuple[int, Detection]], spreads: Array) -> None:
        for k, detection in unknown:
            near = any(math.hypot(t.x - detection.x, t.y - detection.y) < self.parameters.closest for t in self.tracks)
            if near or not detection.begins:
                continue
            self._bank.add([(detection.x, detection.y)], spreads[k : k + 1])
            evidence = _evidence(detection.score)
            track = LocalTrack(self._next, self.at, self.at, evidence, detection.score, x=detection.x, y=detection.y)
            track.confirmed, track.z = evidence >= self.parameters.confirmed_at, detection.z
            self.tracks.append(track)
            self.assigned[k] = track.id
            self._next += 1

    def _join(self, detected: set[int]) -> None:
        """Doubt the younger of two tracks that have been in one place for a time with at most one detected at once."""
        near: dict[tuple[int, int], float] = {}
        for older, younger in combinations(self.tracks, 2):
            pair = older.id, younger.id
            close = math.hypot(older.x - younger.x, older.y - younger.y) < self.parameters.closest
            if close and not detected.issuperset(pair):
                near[pair] = self._near_since.get(pair, self.at)
                if self.at - near[pair] >= self.parameters.joined_after:
                    younger.evidence = 0.0
        self._near_since = near

    def _forget(self) -> None:
        oldest = self.at - self.parameters.forget_after
        kept = [k for k, track in enumerate(self.tracks) if track.evidence > 0.0 and track.last_seen >= oldest]
        if len(kept) < len(self.tracks):
            self.tracks = [self.tracks[k] for k in kept]
            self._bank.keep(np.array(kept, np.intp))

    def _read(self) -> None:
        """Copy the states of the filters into the tracks."""
        means, spreads = self._bank.states()
        for track, mean, spread in zip(self.tracks, means.tolist(), spreads.tolist(), strict=True):
            track.x, track.y, track.vx, track.vy = mean
            track.covariance = spread[0][0], spread[0][1], spread[1][1]


def _arrays(detections: Sequence[Detection]) -> tuple[Array, Array]:
    positions = np.array([(each.x, each.y) for each in detections]).reshape(-1, 2)
    rows = [(xx, xy, xy, yy) for xx, xy, yy in (each.covariance for each in detections)]
    return positions, np.array(rows, np.float64).reshape(-1, 2, 2)


def _evidence(score: float) -> float:
    """Return the logarithm of the odds of a detection with this score, at least a little for any detection."""
    bounded = min(max(score, 0.0), 0.97)
    return max(math.log(bounded / (1.0 - bounded)) if bounded > 0.0 else 0.0, 0.2)
