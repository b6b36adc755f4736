"""Torso IDs: the names of the people that a robot sees."""

from collections.abc import Collection

MOST = 200
"""Number of Torso IDs that are used in turn: listeners of ``tf`` keep every frame that they have heard of."""


class TorsoIds:
    """Torso ID of each track."""

    def __init__(self) -> None:
        self._names: dict[int, str] = {}
        self._next = 1

    def of(self, track: int, wanted: str = "", taken: Collection[str] = ()) -> str:
        """Return the Torso ID of a track, which is the same as long as the track exists.

        Parameters
        ----------
        track : int
            Id of the track.
        wanted : str
            Torso ID that the robot itself gave, which a new track gets if no other has it.
        taken : collection of str
            Torso IDs of frames that the robot publishes itself.
        """
        if track not in self._names:
            used = {*self._names.values(), *taken}
            self._names[track] = wanted if wanted and wanted not in self._names.values() else self._new(used)
        return self._names[track]

    def keep(self, tracks: Collection[int]) -> None:
        """Forget the Torso IDs of all other tracks."""
        self._names = {track: name for track, name in self._names.items() if track in tracks}

    def state(self) -> tuple[int, dict[int, str]]:
        """Return a checkpoint."""
        return self._next, dict(self._names)

    def restore(self, state: tuple[int, dict[int, str]]) -> None:
        """Go on from a checkpoint."""
        self._next, self._names = state[0], dict(state[1])

    def _new(self, used: Collection[str]) -> str:
        """Return the next Torso ID that is free; with all in use, a further one."""
        turn = (number % MOST + 1 for number in range(self._next - 1, self._next - 1 + MOST))
        number = next(number for number in (*turn, *range(MOST + 1, MOST + len(used) + 2)) if _name(number) not in used)
        self._next = number % MOST + 1
        return _name(number)


def _name(number: int) -> str:
    return f"torso_{number}"
