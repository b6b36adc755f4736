"""Docks of ``ppaas bench building``: a robot docks again and again, with errors of all kinds and faulty chargers."""

import math
from collections import Counter
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np

from benchmarks.building.docking_scene import DockingOutcome, DockingScene
from ppaas.docking.parameters import DockingParameters
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from robots.sim.docks.charger import Charger, ChargerFault, ChargerModel
from robots.sim.robot import TurtlebotModel

CHARGED, RETRIES = 0.995, 1.0
"""Bars: part of the goals after which the robot is charged, and mean number of further approaches."""

MOVED, FAULTY = 0.2, 0.05
"""Part of the docks that were moved by `SHIFT`, and part of the chargers that give no current."""

SHIFT = 0.2
"""Distance by which docks were moved [m]."""


class DocksReport(msgspec.Struct):
    """Goals to dock.

    Parameters
    ----------
    goals : int
    charged : int
        Goals after which the robot is charged, as was confirmed and is true.
    wrong : int
        Goals that succeeded while the robot is not charged.
    idle : int
        Goals that failed, and left the robot at its dock without charge.
    retries : float
        Mean number of further approaches.
    seconds : float
        Mean time of a goal [s].
    moved, faulty : int
        Docks that were moved, and first chargers that give no current.
    failures : dict of str to int
        Reasons of the goals that failed.
    """

    goals: int
    charged: int
    wrong: int
    idle: int
    retries: float
    seconds: float
    moved: int
    faulty: int
    failures: dict[str, int]

    @property
    def passed(self) -> bool:
        """Whether all bars are met."""
        enough = self.charged >= CHARGED * self.goals and self.retries <= RETRIES
        return enough and not self.wrong and not self.idle

    def rows(self) -> list[dict[str, Any]]:
        """Return one row."""
        return [
            {
                "goals": self.goals, "docks moved": self.moved, "chargers faulty": self.faulty,
                "charge confirmed": f"{100.0 * self.charged / max(self.goals, 1):.2f} %",
                "retries": f"{self.retries:.3f}", "s": f"{self.seconds:.1f}", "confirmed wrongly": self.wrong,
                "left without charge": self.idle,
            }
        ]  # fmt: skip

    def sentences(self) -> list[str]:
        """Return the bars, and the reasons of failures."""
        bars = f"bars: charge confirmed {100.0 * CHARGED:g} %, retries {RETRIES:g}, and none in the last two columns"
        return [bars, *(f"{count} times: {reason}" for reason, count in self.failures.items())]


def measure_docks(goals: int, seed: int = 0, advance: Callable[[], None] = lambda: None) -> DocksReport:
    """Send a robot to dock from random places, each time in another world.

    Parameters
    ----------
    goals : int
    seed : int
    advance : callable
        Called after each goal.
    """
    failures: Counter[str] = Counter()
    report = DocksReport(goals, 0, 0, 0, 0.0, 0.0, 0, 0, {})
    for number in range(goals):
        scene, moved, faulty = _scene(seed, number)
        outcome = scene.dock("first")
        report.moved, report.faulty = report.moved + moved, report.faulty + faulty
        report.retries += outcome.retries / goals
        report.seconds += outcome.seconds / goals
        _count(report, outcome, failures)
        advance()
    report.failures = dict(failures)
    return report


def _count(report: DocksReport, outcome: DockingOutcome, failures: Counter[str]) -> None:
    charged = outcome.current > 0.0
    if outcome.status is Status.SUCCEEDED:
        report.charged += charged
        report.wrong += not charged
    else:
        failures[outcome.text] += 1
        report.idle += outcome.touches and not charged


def _scene(seed: int, number: int) -> tuple[DockingScene, bool, bool]:
    """Return a scene with two docks, of which the second is tried after the first."""
    rng = np.random.default_rng((seed, number))
    theta = float(rng.uniform(-math.pi, math.pi))
    x, y = rng.uniform(3.0, 5.0, 2).tolist()
    mapped = {"first": Pose2D(x, y, theta)}
    mapped["second"] = mapped["first"] @ Pose2D(0.0, -1.5)
    moved, faulty = bool(rng.random() < MOVED), bool(rng.random() < FAULTY)
    fault = (ChargerFault.DEAD, ChargerFault.LIAR)[int(rng.integers(2))] if faulty else ChargerFault.NOTHING
    chargers = {}
    for name, at in mapped.items():
        angle, turn = float(rng.uniform(-math.pi, math.pi)), float(rng.normal(0.0, 0.05))
        shift = SHIFT if moved else float(abs(rng.normal(0.0, 0.02)))
        true = Pose2D(at.x + shift * math.cos(angle), at.y + shift * math.sin(angle), at.theta + turn)
        model = ChargerModel(lateral=float(rng.uniform(0.015, 0.025)), forward=float(rng.uniform(0.008, 0.02)))
        first = name == "first"
        chargers[name] = Charger(true, TurtlebotModel().radius, model, fault if first else ChargerFault.NOTHING)
    parameters = DockingParameters(next_docks={"first": "second"})
    return DockingScene(chargers, mapped, seed * 100_003 + number, parameters=parameters), moved, faulty
