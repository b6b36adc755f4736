"""A run: robots and people for some simulated minutes, and its figures, with HOTA and MOTA by TrackEval."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.people.runs.job import PeopleJob, PeopleResult
from benchmarks.people.runs.scene import PeopleScene
from ppaas.clock import monotonic
from robots.demo.people_score import PeopleScore, ScoredFrame

Floats = NDArray[np.float64]

# -- HOTA and MOTA of the identities of people, by TrackEval -----------------------------------------------------------

NO_OVERLAP = 2.0
"""Distance at which a person and an identity have nothing in common any more [m], as TrackEval has it in 3D."""


class TrackingMetrics(NamedTuple):
    """Quality of tracks, as fractions: higher order tracking accuracy, and multi-object tracking accuracy."""

    hota: float
    mota: float


class TrackRecord:
    """People in view and the identities at the times of a run.

    As usual in such benches, a person at the edge of the views is neither missed nor wrong: neither that person nor
    its identity is part of the record then.
    """

    def __init__(self) -> None:
        self._people: list[NDArray[np.int64]] = []
        self._identities: list[NDArray[np.int64]] = []
        self._similarities: list[Floats] = []
        self._number_of: dict[int, int] = {}
        self._person_number: dict[int, int] = {}

    def take(self, frame: ScoredFrame, people: Floats) -> None:
        """Add a time: its frame, and the true positions of all people (n, 2) [m]."""
        in_view = np.flatnonzero(frame.in_view)
        person_of = np.array([frame.person_of.get(identity, -1) for identity in frame.identities], dtype=np.int64)
        kept = ~np.isin(person_of, np.flatnonzero(frame.at_edge))
        identities = np.array(frame.identities, dtype=np.int64)[kept]
        far = np.hypot(*(people[in_view][:, np.newaxis] - frame.positions[kept]).transpose(2, 0, 1))
        self._people.append(_numbered(self._person_number, in_view))
        self._identities.append(_numbered(self._number_of, identities))
        self._similarities.append(np.maximum(0.0, 1.0 - far / NO_OVERLAP))

    def metrics(self) -> TrackingMetrics:
        """Return the metrics of all times; 1 if there was nobody to track, and nobody was tracked."""
        from trackeval.metrics import CLEAR, HOTA  # noqa: PLC0415 - of the extra bench

        data = {
            "num_timesteps": len(self._people),
            "num_gt_ids": len(self._person_number), "num_tracker_ids": len(self._number_of),
            "num_gt_dets": sum(map(len, self._people)), "num_tracker_dets": sum(map(len, self._identities)),
            "gt_ids": self._people, "tracker_ids": self._identities, "similarity_scores": self._similarities,
        }  # fmt: skip
        if not data["num_gt_dets"] and not data["num_tracker_dets"]:
            return TrackingMetrics(1.0, 1.0)
        hota = float(np.mean(HOTA().eval_sequence(data)["HOTA"]))
        mota = float(CLEAR({"PRINT_CONFIG": False}).eval_sequence(data)["MOTA"])
        return TrackingMetrics(round(hota, 4), round(mota, 4))


def _numbered(numbers: dict[int, int], ids: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the number of each id, from 0 in the order in which they first appear."""
    return np.array([numbers.setdefault(int(each), len(numbers)) for each in ids], dtype=np.int64)


Watch = Callable[[PeopleScene, ScoredFrame], None]
"""Called with the scene and its last frame after each state of the coordinator."""


def run(job: PeopleJob, watch: Watch | None = None) -> PeopleResult:
    """Simulate a run, and return its figures."""
    began = monotonic()
    scene = PeopleScene(job)
    score, record = PeopleScore(job.people), TrackRecord()
    while scene.world.time() < 60.0 * job.minutes:
        if not scene.step() or scene.state is None or scene.truth is None:
            continue
        frame = score.take(scene.truth, scene.state)
        record.take(frame, scene.truth.people)
        if watch is not None:
            watch(scene, frame)
    figures, tracking = score.figures(scene.contacts()), record.metrics()
    return PeopleResult(
        job.map, job.robots, job.people, job.policy, job.seed, figures.count_error_mean, figures.count_exact,
        figures.identity_switches, figures.followed_fraction, figures.handovers, figures.flaps, figures.contacts,
        figures.seen, figures.ghosts, tracking.hota, tracking.mota, scene.world.time(),
        round(monotonic() - began, 1), round(float(np.quantile(scene.group.cycles, 0.99)), 5), job.fault,
    )  # fmt: skip
