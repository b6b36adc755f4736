"""The room a robot takes up, standing upright: from its frame upwards."""

import math
from dataclasses import dataclass

from ppaas.errors import InvalidParameter


@dataclass(frozen=True, slots=True)
class Cylinder:
    """An upright cylinder whose base is centred on the robot's frame.

    Parameters
    ----------
    radius : float
        Zero or more [m].
    height : float
        More than zero [m].

    Raises
    ------
    InvalidParameter
        One of them is out of range.
    """

    radius: float
    height: float

    def __post_init__(self) -> None:
        _check(self.height, "height")
        if not (math.isfinite(self.radius) and self.radius >= 0.0):
            raise InvalidParameter(f"the radius of a robot must be zero or more metres, not {self.radius}")

    @property
    def half_length(self) -> float:
        """Half of what it takes up along its heading with straight faces: nothing [m]."""
        return 0.0

    @property
    def half_width(self) -> float:
        """Half of what it takes up across its heading with straight faces: nothing [m]."""
        return 0.0

    @property
    def swept_radius(self) -> float:
        """Radius of the cylinder in which it can turn [m]."""
        return self.radius


@dataclass(frozen=True, slots=True)
class Box:
    """An upright box whose base is centred on the robot's frame.

    Parameters
    ----------
    length, width, height : float
        Along the robot's x, y and z; more than zero [m].

    Raises
    ------
    InvalidParameter
        One of them is out of range.
    """

    length: float
    width: float
    height: float

    def __post_init__(self) -> None:
        for name in ("length", "width", "height"):
            _check(getattr(self, name), name)

    @property
    def half_length(self) -> float:
        """[m]."""
        return self.length / 2.0

    @property
    def half_width(self) -> float:
        """[m]."""
        return self.width / 2.0

    @property
    def radius(self) -> float:
        """How far it reaches beyond its faces: nothing [m]."""
        return 0.0

    @property
    def swept_radius(self) -> float:
        """Radius of the cylinder in which it can turn [m]."""
        return math.hypot(self.half_length, self.half_width)


Volume = Cylinder | Box


def _check(value: float, name: str) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise InvalidParameter(f"the {name} of a robot must be more than zero metres, not {value}")
