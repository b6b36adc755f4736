"""Parameters of mapping, named as in slam_toolbox and gmapping where one of theirs fits."""

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, check_numbers

MAX_SCAN_BUFFER = 64
"""Largest number of key frames that a scan is tracked against."""


class SlamParameters(Parameters, frozen=True):
    """Parameters of the front end, in metres and radians. One set of defaults serves all lasers.

    Of slam_toolbox: ``minimum_travel_distance`` and ``minimum_travel_heading`` make a scan a key frame;
    ``scan_buffer_size`` is the number of key frames that a scan is tracked against; the search for the start has
    ``correlation_search_space_resolution`` and ``correlation_search_space_smear_deviation``, steps of
    ``coarse_angle_resolution``, and a window of ``correlation_search_space_dimension`` plus twice the standard
    deviation of the odometry to each side. ``resolution`` is the drawn map's.

    Of gmapping: the standard deviations of an odometry step, ``srr`` of the translation by the distance [m/m], ``srt``
    of the translation by the turn [m/rad], ``str`` of the heading by the distance [rad/m], ``stt`` of the heading by
    the turn [rad/rad].

    Others: ``odometry_deviation`` and ``odometry_heading_deviation`` are the standard deviations of a step of length 0;
    ``normal_angle`` is the angle to each side whose beams a line is fitted to; a neighbourhood thicker than
    ``normal_thickness`` has no normal. ``max_key_frames`` bounds the memory.
    """

    minimum_travel_distance: float = 0.25
    minimum_travel_heading: float = 0.2
    minimum_laser_range: float = 0.05
    max_laser_range: float = 40.0
    resolution: float = 0.05
    scan_buffer_size: int = 8
    correlation_scans: int = 30
    correlation_search_space_dimension: float = 0.05
    correlation_search_space_resolution: float = 0.1
    correlation_search_space_smear_deviation: float = 0.1
    coarse_angle_resolution: float = 0.017
    normal_angle: float = 0.09
    normal_thickness: float = 0.03
    odometry_deviation: float = 0.01
    odometry_heading_deviation: float = 0.02
    max_key_frames: int = 100_000
    srr: float = 0.1
    srt: float = 0.02
    str: float = 0.1
    stt: float = 0.3

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=_POSITIVE)
        if self.minimum_laser_range >= self.max_laser_range:
            raise InvalidParameter(
                "minimum_laser_range must be below max_laser_range, "
                f"not {self.minimum_laser_range} and {self.max_laser_range}"
            )
        if self.scan_buffer_size > MAX_SCAN_BUFFER:
            raise InvalidParameter(f"scan_buffer_size must be at most {MAX_SCAN_BUFFER}, not {self.scan_buffer_size}")


_POSITIVE = (
    "minimum_travel_distance", "minimum_travel_heading", "max_laser_range", "resolution", "scan_buffer_size",
    "correlation_scans", "correlation_search_space_resolution", "correlation_search_space_smear_deviation",
    "coarse_angle_resolution", "normal_angle", "normal_thickness", "odometry_deviation", "odometry_heading_deviation",
    "max_key_frames",
)  # fmt: skip
