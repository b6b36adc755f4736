"""A run: robots and people for some simulated minutes, and its figures."""

from collections.abc import Callable

import numpy as np

from benchmarks.people.runs.job import PeopleJob, PeopleResult
from benchmarks.people.runs.scene import PeopleScene
from benchmarks.people.runs.tracking_metrics import TrackRecord
from ppaas.clock import monotonic
from robots.demo.people_score import Frame, PeopleScore

Watch = Callable[[PeopleScene, Frame], None]
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
