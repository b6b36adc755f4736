"""Clocks of a robot's devices: stamps of detections in the time of the odometry, and in that of this computer."""

from ppaas.errors import InvalidInput
from ppaas.people.robot_tracks.clock_offsets import LATEST, TOLERANCE, ClockOffset, corrected

ODOMETRY = "odometry"


class DeviceClocks:
    """Offsets of the clocks of odometry and detectors."""

    def __init__(self) -> None:
        self._offsets: dict[str, ClockOffset] = {ODOMETRY: ClockOffset()}

    def note_odometry(self, stamp: float, now: float) -> None:
        """Note the stamp of odometry that arrives at ``now`` [s]."""
        self._offsets[ODOMETRY].note(stamp, now)

    def in_odometry(self, source: str, stamp: float, now: float, newest: float | None) -> float:
        """Return the stamp of a detection that arrives now by the clock of the odometry [s].

        Parameters
        ----------
        source : str
            Topic of the detection.
        stamp : float
            By the clock of its device [s]; 0 for the time of the newest odometry, and unchanged.
        now : float
            Time of stamps [s].
        newest : float or None
            Stamp of the newest odometry [s]; without odometry the stamp is unchanged.

        Raises
        ------
        InvalidInput
            It is out of date: later by `LATEST` than the others of this topic.
        """
        if not stamp or newest is None:
            return stamp
        offset = self._offsets.setdefault(source, ClockOffset())
        delay = offset.note(stamp, now)
        if delay > LATEST:
            raise InvalidInput(
                f"detections on {source!r} are stamped {delay:.1f} s earlier than the others before them: they are out "
                "of date, send each once, as soon as it is made"
            )
        apart = offset.seconds - self._offsets[ODOMETRY].seconds
        return stamp + apart if abs(apart) > TOLERANCE else stamp

    def here(self, stamp: float) -> float:
        """Return a time of the odometry by the clock of this computer [s]."""
        return corrected(stamp, self._offsets[ODOMETRY].seconds)
