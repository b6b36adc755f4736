"""Restoration of a map: the mapper of a log, rebuilt in a job."""

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ppaas.change_log import LogEntry
from ppaas.errors import QuotaExceeded
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.serialization.mapping_log import LogWriter, read_log
from ppaas.nodes.grid_slam.laser import MappingLaser
from ppaas.nodes.grid_slam.logbook import Head, resume


class RestoredMap(NamedTuple):
    """Map of a log.

    Parameters
    ----------
    laser : MappingLaser
    mapper : LiveMapper
    writer : LogWriter
        Of the same log, which it continues.
    """

    laser: MappingLaser
    mapper: LiveMapper
    writer: LogWriter


@dataclass(frozen=True, slots=True)
class Restoration:
    """Work that rebuilds the map of a log. It may be run again.

    Parameters
    ----------
    entries : sequence of LogEntry
        All entries, sorted by number.
    head : Head or None
        Where the robot is.
    parameters : SlamParameters
        Of the front end.
    new_mapper : callable
        Returns a mapper without a map for a laser.
    """

    entries: Sequence[LogEntry]
    head: Head | None
    parameters: SlamParameters
    new_mapper: Callable[[MappingLaser], LiveMapper]

    def __call__(self, _cancelled: Callable[[], bool]) -> RestoredMap:
        """Return the map.

        Raises
        ------
        InvalidGraph
            The log is damaged.
        QuotaExceeded
            The map has more key frames than allowed.
        """
        mapping = read_log(self.entries)
        writer = LogWriter.resumed(self.entries, mapping)
        laser = MappingLaser(mapping.laser_frame, mapping.frames.geometry, self.parameters)
        mapper = self.new_mapper(laser)
        resume(mapper, mapping, self.head)
        draw(mapper)
        return RestoredMap(laser, mapper, writer)


def draw(mapper: LiveMapper) -> None:
    """Draw the key frames of a mapper that was just made, while no scan waits for it.

    A map that is too large to be drawn is reported when the next key frame is.
    """
    with contextlib.suppress(QuotaExceeded):
        mapper.draw()
