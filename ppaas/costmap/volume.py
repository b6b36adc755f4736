"""Volume of an upright robot, from its base frame upwards."""

import math
from dataclasses import dataclass

from ppaas.errors import InvalidParameter


@dataclass(frozen=True, slots=True)
class Cylinder:
    """Upright cylinder whose base is centred on the robot's frame.

    Parameters
    ----------
    radius : float
        At least 0 [m].
    height : float
        Above 0 [m].

    Raises
    ------
    InvalidParameter
        A size is out of range.
    """

    radius: float
    height: float

    def __post_init__(self) -> None:
        _check(self.height, "height")
        if not (math.isfinite(self.radius) and self.radius >= 0.0):
            raise InvalidParameter(f"the robot's radius must be at least 0 metres and finite, not {self.radius}")

    @property
    def half_length(self) -> float:
        """Half length of the rectangle that ``radius`` extends, here 0 [m]."""
        return 0.0

    @property
    def half_width(self) -> float:
        """Half width of the rectangle that ``radius`` extends, here 0 [m]."""
        return 0.0

    @property
    def swept_radius(self) -> float:
        """Radius of the cylinder in which the robot can turn on the spot [m]."""
        return self.radius


@dataclass(frozen=True, slots=True)
class Box:
    """Upright box whose base is centred on the robot's frame.

    Parameters
    ----------
    length, width, height : float
        Sizes along the robot's x, y and z; above 0 [m].

    Raises
    ------
    InvalidParameter
        A size is out of range.
    """

    length: float
    width: float
    height: float

    def __post_init__(self) -> None:
        for name in ("length", "width", "height"):
            _check(getattr(self, name), name)

    @property
    def half_length(self) -> float:
        """Half of the length [m]."""
        return self.length / 2.0

    @property
    def half_width(self) -> float:
        """Half of the width [m]."""
        return self.width / 2.0

    @property
    def radius(self) -> float:
        """Extension of the rectangle to all sides, here 0 [m]."""
        return 0.0

    @property
    def swept_radius(self) -> float:
        """Radius of the cylinder in which the robot can turn on the spot [m]."""
        return math.hypot(self.half_length, self.half_width)


Volume = Cylinder | Box


def _check(value: float, name: str) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise InvalidParameter(f"the robot's {name} must be above 0 metres and finite, not {value}")
