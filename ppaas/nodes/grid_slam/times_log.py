"""Times of key frames in the log of a map: entries beside its mapping's entries."""

import logging
from collections.abc import Sequence

from ppaas.change_log import LogChange, LogEntry
from ppaas.errors import InvalidGraph
from ppaas.mapping.serialization.mapping_log import FOLD, LogWriter
from ppaas.mapping.serialization.records import RecordKind, pack_record, unpack_records
from ppaas.mapping.serialization.rows import pack_times, unpack_times
from ppaas.nodes.key_frame_path import KeyFrameTimes

logger = logging.getLogger(__name__)


class TimesLog:
    """Entries with the times of key frames. `FOLD` small entries are replaced by one."""

    def __init__(self) -> None:
        self._of: tuple[LogWriter | None, int] = None, 0
        self._written = 0
        self._entries: list[int] = []

    def change(self, writer: LogWriter, times: KeyFrameTimes) -> LogChange | None:
        """Return the times since the last call; all of them in another log, or if known ones have changed.

        Parameters
        ----------
        writer : LogWriter
            Of the log, in which they get numbers.
        times : KeyFrameTimes
        """
        obsolete: list[int] = []
        before, edition = self._of
        if writer is not before:  # its first change makes all entries of the last log obsolete
            self._entries, self._written = [], 0
        elif edition != times.edition or len(self._entries) >= FOLD:
            obsolete, self._entries, self._written = self._entries, [], 0
        self._of = writer, times.edition
        begin, self._written = self._written, len(times.numbers)
        if begin == self._written:
            return LogChange([], obsolete) if obsolete else None
        payload = pack_times(times.numbers[begin:], times.stamps[begin:])
        entry = writer.add(pack_record(RecordKind.TIMES, payload))
        self._entries.append(entry.number)
        return LogChange([entry], obsolete)

    def read(self, entries: Sequence[LogEntry], times: KeyFrameTimes) -> None:
        """Read the times of all entries of a log; of a damaged one, none: the map is then lost, too."""
        found: dict[int, float] = {}
        self._entries = []
        try:
            for number, data in entries:
                for _, (kind, payload) in unpack_records(data):
                    if kind == RecordKind.TIMES:
                        self._entries.append(number)
                        found |= dict(zip(*unpack_times(payload), strict=True))
        except InvalidGraph as error:
            logger.debug("the times of key frames cannot be read: %s", error)
            found = {}
        known = sorted((stamp, number) for number, stamp in found.items())
        times.use([number for _, number in known], [stamp for stamp, _ in known])

    def resume(self, writer: LogWriter, times: KeyFrameTimes) -> None:
        """Continue the log whose entries were read, by its writer."""
        self._of, self._written = (writer, times.edition), len(times.numbers)
