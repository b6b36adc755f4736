"""Places on floors of a building: x, y and yaw as all places of tasks, and the floor on whose map they are."""


class PlaceOnFloor(tuple[float, float, float]):
    """Place on a floor of a building. The same numbers on another floor are another place.

    Parameters
    ----------
    place : Place
        x, y [m], yaw [rad] in the frame of the map of the floor.
    floor : str
        Name of the floor.
    """

    floor: str

    def __new__(cls, place: tuple[float, float, float], floor: str) -> "PlaceOnFloor":
        """Return a place on a floor."""
        made = super().__new__(cls, place)
        made.floor = floor
        return made

    def __eq__(self, other: object) -> bool:
        """Return whether it is the same place on the same floor."""
        return isinstance(other, PlaceOnFloor) and self.floor == other.floor and tuple.__eq__(self, other)

    def __ne__(self, other: object) -> bool:
        """Return whether it is another place; tuples have a method for this, too."""
        return not self == other

    def __hash__(self) -> int:
        """Return a hash of place and floor."""
        return hash((self.floor, tuple.__hash__(self)))


def on_floor(place: tuple[float, float, float], floor: str) -> tuple[float, float, float]:
    """Return a place on a floor; the place itself if the floor is empty, as on a map without a building."""
    return PlaceOnFloor(place, floor) if floor else place


def floor_of(place: tuple[float, float, float]) -> str:
    """Return the floor of a place; empty on a map without a building."""
    return place.floor if isinstance(place, PlaceOnFloor) else ""


def bare(place: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return a place without its floor."""
    x, y, yaw = place
    return x, y, yaw
