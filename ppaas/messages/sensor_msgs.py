"""``sensor_msgs``."""

from enum import IntEnum
from typing import Annotated, ClassVar

from msgspec import Meta, field

from ppaas.messages.base.message import Float32, Message, UInt8, UInt32
from ppaas.messages.base.std_msgs import Header


class LaserScan(Message):
    """``sensor_msgs/LaserScan``.

    Angles in radians, counter-clockwise about z of the sensor's frame; ranges in metres. A range that is null or
    outside [range_min, range_max] is not a reading.
    """

    ros_order: ClassVar[tuple[str, ...]] = (
        "header", "angle_min", "angle_max", "angle_increment", "time_increment", "scan_time", "range_min", "range_max",
        "ranges", "intensities",
    )  # fmt: skip

    header: Header
    angle_min: Float32
    angle_max: Float32
    angle_increment: Float32
    range_min: Float32
    range_max: Float32
    ranges: list[Float32 | None]
    time_increment: Float32 = 0.0
    scan_time: Float32 = 0.0
    intensities: list[Float32 | None] = field(default_factory=list)


class LaserEcho(Message):
    """``sensor_msgs/LaserEcho``: ranges [m] or intensities of one beam, the nearest first."""

    ros_order: ClassVar[tuple[str, ...]] = ("echoes",)

    echoes: list[Float32 | None]


class MultiEchoLaserScan(Message):
    """``sensor_msgs/MultiEchoLaserScan``: a scan whose beams have several ranges each, otherwise as `LaserScan`."""

    ros_order: ClassVar[tuple[str, ...]] = LaserScan.ros_order

    header: Header
    angle_min: Float32
    angle_max: Float32
    angle_increment: Float32
    range_min: Float32
    range_max: Float32
    ranges: list[LaserEcho]
    time_increment: Float32 = 0.0
    scan_time: Float32 = 0.0
    intensities: list[LaserEcho] = field(default_factory=list)


class PointFieldType(IntEnum):
    """Values of ``datatype`` of ``sensor_msgs/PointField``."""

    INT8 = 1
    UINT8 = 2
    INT16 = 3
    UINT16 = 4
    INT32 = 5
    UINT32 = 6
    FLOAT32 = 7
    FLOAT64 = 8


class Image(Message):
    """``sensor_msgs/Image``.

    Parameters
    ----------
    encoding : str
        Pixel format: ``16UC1`` is a depth in mm, ``32FC1`` a depth in m.
    is_bigendian : int
        Not 0 if the most significant byte of a number is the first.
    step : int
        Length of a row [bytes].
    data : bytes
        All rows; base64 in JSON.
    """

    header: Header
    height: UInt32
    width: UInt32
    encoding: str
    is_bigendian: UInt8
    step: UInt32
    data: bytes


class CompressedImage(Message):
    """``sensor_msgs/CompressedImage``; ``data`` is base64 in JSON."""

    header: Header
    format: str
    data: bytes


class RegionOfInterest(Message):
    """``sensor_msgs/RegionOfInterest`` [pixels]; all zero for the whole image."""

    x_offset: UInt32 = 0
    y_offset: UInt32 = 0
    height: UInt32 = 0
    width: UInt32 = 0
    do_rectify: bool = False


class CameraInfo(Message):
    """``sensor_msgs/CameraInfo``, spelled as in ROS 1: matrices have capital letters.

    Parameters
    ----------
    K : list of 9 floats
        Intrinsic camera matrix, row-major: fx, 0, cx, 0, fy, cy, 0, 0, 1 [pixels].
    """

    ros_order: ClassVar[tuple[str, ...]] = (
        "header", "height", "width", "distortion_model", "D", "K", "R", "P", "binning_x", "binning_y", "roi",
    )  # fmt: skip

    header: Header
    height: UInt32
    width: UInt32
    K: Annotated[list[float], Meta(extra={"length": 9})]
    distortion_model: str = ""
    D: list[float] = field(default_factory=list)
    R: Annotated[list[float], Meta(extra={"length": 9})] = field(default_factory=list)
    P: Annotated[list[float], Meta(extra={"length": 12})] = field(default_factory=list)
    binning_x: UInt32 = 0
    binning_y: UInt32 = 0
    roi: RegionOfInterest = field(default_factory=RegionOfInterest)


class PointField(Message):
    """``sensor_msgs/PointField``: a field of the points of a cloud.

    Parameters
    ----------
    offset : int
        Offset from the beginning of a point [bytes].
    datatype : int
        Type of its numbers: 7 is float32, 8 is float64.
    count : int
        Number of its numbers.
    """

    constants: ClassVar[type[IntEnum] | None] = PointFieldType

    name: str
    offset: UInt32
    datatype: UInt8
    count: UInt32


class PointCloud2(Message):
    """``sensor_msgs/PointCloud2``.

    Parameters
    ----------
    fields : list of PointField
        Fields of a point.
    point_step, row_step : int
        Length of a point and of a row [bytes].
    data : bytes
        All rows; base64 in JSON.
    is_dense : bool
        Whether no point is invalid.
    """

    header: Header
    height: UInt32
    width: UInt32
    fields: list[PointField]
    is_bigendian: bool
    point_step: UInt32
    row_step: UInt32
    data: bytes
    is_dense: bool


# -- batteries ---------------------------------------------------------------------------------------------------------


class PowerSupplyStatus(IntEnum):
    """Values of ``power_supply_status`` of ``sensor_msgs/BatteryState``."""

    POWER_SUPPLY_STATUS_UNKNOWN = 0
    POWER_SUPPLY_STATUS_CHARGING = 1
    POWER_SUPPLY_STATUS_DISCHARGING = 2
    POWER_SUPPLY_STATUS_NOT_CHARGING = 3
    POWER_SUPPLY_STATUS_FULL = 4


class BatteryState(Message, forbid_unknown_fields=False):
    """``sensor_msgs/BatteryState``; what a robot does not measure is null, or left out.

    Parameters
    ----------
    current : float, optional
        Negative when discharging [A].
    percentage : float, optional
        Charge from 0 to 1.
    """

    ros_order: ClassVar[tuple[str, ...]] = (
        "header", "voltage", "temperature", "current", "charge", "capacity", "design_capacity", "percentage",
        "power_supply_status", "power_supply_health", "power_supply_technology", "present", "cell_voltage",
        "cell_temperature", "location", "serial_number",
    )  # fmt: skip
    constants: ClassVar[type[IntEnum] | None] = PowerSupplyStatus

    header: Header = field(default_factory=Header)
    voltage: Float32 | None = None
    temperature: Float32 | None = None
    current: Float32 | None = None
    charge: Float32 | None = None
    capacity: Float32 | None = None
    design_capacity: Float32 | None = None
    percentage: Float32 | None = None
    power_supply_status: UInt8 = 0
    power_supply_health: UInt8 = 0
    power_supply_technology: UInt8 = 0
    present: bool = False
    cell_voltage: list[Float32 | None] = field(default_factory=list)
    cell_temperature: list[Float32 | None] = field(default_factory=list)
    location: str = ""
    serial_number: str = ""


class FluidPressure(Message):
    """``sensor_msgs/FluidPressure``: what a barometer measures.

    Parameters
    ----------
    header : Header
    fluid_pressure : float
        Absolute pressure [Pa].
    variance : float
        Variance [Pa²]; 0 if it is not known.
    """

    header: Header
    fluid_pressure: float
    variance: float = 0.0
