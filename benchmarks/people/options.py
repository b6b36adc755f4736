"""Options and result of a part of ``ppaas bench people``."""

from dataclasses import dataclass
from pathlib import Path

from benchmarks.people.runs.job import PeopleJob


@dataclass(frozen=True, slots=True)
class PeopleOptions:
    """Options of all parts.

    Parameters
    ----------
    jobs : tuple of PeopleJob
        Runs of the part ``coordination``.
    processes : int
        Number of runs at once.
    keep : Path, optional
        File of the results of runs; runs that it contains are not repeated.
    size : tuple of int
        Width and height of depth images [pixels].
    seed : int
    data : Path, optional
        Folder of recorded data: ``depth`` has depth images.
    quick : bool
        Whether to take few samples.
    """

    jobs: tuple[PeopleJob, ...] = ()
    processes: int = 1
    keep: Path | None = None
    size: tuple[int, int] = (320, 240)
    seed: int = 0
    data: Path | None = None
    quick: bool = False
