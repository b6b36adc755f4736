"""Sightings of one cycle: torsos of all robots become people, and update their filters."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.people.coordinator.group import MemberRobot
from ppaas.people.coordinator.identities import NOBODY, Known, Torsos, recognize
from ppaas.people.coordinator.parameters import CoordinatorParameters
from ppaas.people.coordinator.people_table import CONFIRMED, MOST_EVIDENCE, PeopleTable
from ppaas.people.coordinator.positions import without_offset
from ppaas.people.tracks.filter_bank import inverse_2x2

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

WANDERS = 0.8
"""Speed by which a torso that is new may have moved since its measurement [m/s]."""
TURNS = 0.3
"""The same of a torso whose velocity is known [m/s]."""
NEAR = 1.3
"""Distance to a person whom only other robots see within which a new torso may be that person [m]."""
WAITS = 3
"""Observations for which such a torso is not counted."""


@dataclass(frozen=True, slots=True)
class Sightings:
    """The T torsos of one cycle, and whose they are.

    Parameters
    ----------
    robots : list of MemberRobot
        Those with a new report, in the order of precedence.
    owners : (T,) int array
        Number of the robot of each torso.
    people : (T,) int array
        Row of its person.
    positions, covariances : (T, 2), (T, 2, 2) array
        In the frame of the map, moved to the time of the cycle [m, m²].
    scores : (T,) array
    """

    robots: list[MemberRobot]
    owners: Ints
    people: Ints
    positions: Array
    covariances: Array
    scores: Array


def observe(
    table: PeopleTable, robots: Sequence[MemberRobot], now: float, parameters: CoordinatorParameters
) -> Sightings:
    """Recognize the people in new reports, and update the table by them.

    Parameters
    ----------
    table : PeopleTable
        Predicted until ``now``; it is modified.
    robots : sequence of MemberRobot
        Robots with a new report that are trusted. Their order does not matter.
    now : float
        [s]
    parameters : CoordinatorParameters
    """
    uncertainties = {robot.name: robot.uncertainty for robot in robots}
    ordered = sorted(robots, key=lambda robot: (round(uncertainties[robot.name], 2), robot.name))
    torsos, scores, ages = _stacked(table, ordered, [uncertainties[robot.name] for robot in ordered], now)
    people = recognize(torsos, _known(table, now), parameters)
    _move_on(table, torsos, people, ages)
    known = len(table)
    rows, positions, covariances = fused(people, torsos.positions, torsos.covariances)
    old = rows < known
    table.update(rows[old].tolist(), positions[old], covariances[old])
    if not old.all():
        table.begin(positions[~old], covariances[~old], now)
        _make_wait(table, known, torsos, people)
    _note(table, torsos, people, scores, now)
    ids = iter([table.rows[row].id for row in people.tolist()])
    for robot in ordered:
        robot.bind({torso: next(ids) for torso in robot.report.ids})
        robot.fresh = False
    return Sightings(ordered, torsos.robots, people, torsos.positions, torsos.covariances, scores)


def _stacked(
    table: PeopleTable, robots: Sequence[MemberRobot], uncertainties: Sequence[float], now: float
) -> tuple[Torsos, Array, Array]:
    """Return the torsos of all robots with these uncertainties [m], their scores and their ages [s]."""
    row_of = table.row_of()
    counts = [len(robot.report.ids) for robot in robots]
    owners = np.repeat(np.arange(len(robots)), counts)
    before = np.array(
        [row_of.get(robot.bound.get(each, NOBODY), NOBODY) for robot in robots for each in robot.report.ids], np.intp
    )
    ages = np.repeat(np.array([max(now - robot.measured, 0.0) for robot in robots]), counts)
    believed = np.concatenate([np.zeros((0, 2)), *(robot.world for robot in robots)])
    origins = np.array([(robot.report.pose.x, robot.report.pose.y) for robot in robots]).reshape(-1, 2)
    offsets = np.array([robot.offset.mean for robot in robots]).reshape(-1, 3)
    positions = without_offset(believed, origins[owners], offsets[owners])
    covariances = np.concatenate([np.zeros((0, 2, 2)), *(robot.spread for robot in robots)])
    moved = np.where(before >= 0, TURNS, WANDERS) * ages
    covariances = covariances + (moved**2)[:, np.newaxis, np.newaxis] * np.eye(2)
    if len(table):
        velocities = np.where((before >= 0)[:, np.newaxis], table.velocities[before], 0.0)
        positions = positions + ages[:, np.newaxis] * velocities
    deviations = np.repeat(np.array(uncertainties), counts)
    scores = np.concatenate([np.zeros(0), *(robot.report.scores for robot in robots)])
    return Torsos(owners, positions, covariances, deviations, before), scores, ages


def _known(table: PeopleTable, now: float) -> Known:
    hidden = np.array([0.0 if person.seen_by else max(now - person.last_seen, 0.0) for person in table.rows])
    deviations = np.array([person.deviation for person in table.rows])
    return Known(table.positions, table.covariances, deviations, hidden)


def _move_on(table: PeopleTable, torsos: Torsos, people: Ints, ages: Array) -> None:
    """Move the torsos of which the person is known only now to the time of the cycle, in place."""
    late = (torsos.before == NOBODY) & (people < len(table))
    torsos.positions[late] += ages[late, np.newaxis] * table.velocities[people[late]]


def fused(people: Ints, positions: Array, covariances: Array) -> tuple[Ints, Array, Array]:
    """Return the people with a sighting, and the means of their sightings by information, with covariances."""
    rows, which = np.unique(people, return_inverse=True)
    inverse, _ = inverse_2x2(covariances)
    information, vectors = np.zeros((len(rows), 2, 2)), np.zeros((len(rows), 2))
    np.add.at(information, which, inverse)
    np.add.at(vectors, which, (inverse @ positions[..., np.newaxis])[..., 0])
    total, _ = inverse_2x2(information)
    return rows, (total @ vectors[..., np.newaxis])[..., 0], total


def _make_wait(table: PeopleTable, first: int, torsos: Torsos, people: Ints) -> None:
    """Make new people wait who may be known ones, whom their robot sees at another position than the others do."""
    if not first:
        return
    seers: dict[int, set[int]] = {}
    for owner, row in zip(torsos.robots.tolist(), people.tolist(), strict=True):
        seers.setdefault(row, set()).add(owner)
    seen = np.array([bool(person.seen_by) for person in table.rows[:first]])
    for row in range(first, len(table)):
        off = table.positions[:first] - table.positions[row]
        near = np.flatnonzero(seen & (np.hypot(off[:, 0], off[:, 1]) < NEAR))
        if len(seers[row]) < 2 and any(not seers.get(int(other), set()) & seers[row] for other in near):
            table.rows[row].waits = WAITS


def _note(table: PeopleTable, torsos: Torsos, people: Ints, scores: Array, now: float) -> None:
    """Note the evidence of sightings in the records of the people."""
    gains, least = np.zeros(len(table)), np.full(len(table), np.inf)
    np.add.at(gains, people, evidence_of(scores))
    np.minimum.at(least, people, torsos.deviations)
    for row in sorted(set(people.tolist())):
        person = table.rows[row]
        person.evidence = min(max(person.evidence, 0.0) + float(gains[row]), MOST_EVIDENCE)
        person.confirmed |= person.evidence >= CONFIRMED and person.waits <= 0
        person.waits -= 1
        person.last_seen = now
        person.deviation = float(least[row])


def evidence_of(scores: Array) -> Array:
    """Return the logarithms of the odds of detections with these scores, a little for any detection."""
    bounded = np.clip(scores, 0.05, 0.97)
    return np.maximum(np.log(bounded / (1.0 - bounded)), 0.2)
