"""Parameters of ``grid_slam``, named as in slam_toolbox and gmapping."""

import math
from typing import Any, Literal

from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.map_drawing import DrawingSettings
from ppaas.mapping.parameters import SlamParameters
from ppaas.nodes.frames import BASE_LINK, MAP, FrameNames
from ppaas.parameters import check_numbers

LIVE_KEY_FRAMES = 20_000
"""Default of ``max_key_frames``: 124 MB with 360 beams."""

CLOSURES = ClosureParameters()
"""Default parameters of the search for closures."""

GMAPPING = {
    "delta": "resolution",
    "linearUpdate": "minimum_travel_distance",
    "angularUpdate": "minimum_travel_heading",
    "maxUrange": "max_laser_range",
    "occ_thresh": "occupancy_threshold",
    "temporalUpdate": "minimum_time_interval",
}
"""Names of gmapping, and the parameters that they set."""

WITHOUT_EFFECT = (
    "lifelong_search_use_tree", "lifelong_minimum_score", "lifelong_node_removal_score", "lifelong_overlap_score_scale",
    "lifelong_constraint_multiplier", "lifelong_nearby_penalty", "lifelong_candidates_scale",
)  # fmt: skip
"""Parameters of slam_toolbox that are accepted without effect: they weigh its score of key frames, which decays."""


class GridSlamParameters(SlamParameters, frozen=True):
    """Parameters of `GridSlamNode`, in metres, radians and seconds; the front end's are in `SlamParameters`.

    Of slam_toolbox: every ``throttle_scans``-th scan is used, and none within ``minimum_time_interval`` of the last
    one. The whole map is published every ``map_update_interval``, if it has changed; its changes at least once per
    second. ``transform_publish_period`` of 0 publishes no transform; otherwise one is published with each scan, stamped
    ``transform_timeout`` ahead. ``do_loop_closing`` searches for closures within ``loop_search_maximum_distance``; the
    other parameters of the search are in `ClosureParameters`. A cell is known if ``min_pass_through`` beams reach it,
    and occupied if a part of them of ``occupancy_threshold`` end there. ``paused_new_measurements`` starts paused.
    ``inf_is_valid``, as of costmap_2d, takes space as free up to ``max_laser_range``, or the range of the laser if that
    is less, along beams that hit nothing there; so does a ``maxUrange`` below the range of the laser, as in gmapping.

    ``map_file_name`` is the name of a published map with a pose graph, which is continued from ``map_start_pose`` (x, y
    [m], yaw [rad]), or else from its first key frame. With ``mode`` ``localization`` that map stays as it is. With
    ``mode`` ``lifelong`` a map that grows has a number of key frames that the area bounds: one is removed if others
    show a part of ``lifelong_iou_match`` of its points. The other parameters of that mode are `WITHOUT_EFFECT`.

    Frames: ``odom_frame`` is by default the frame that the odometry names, ``base_frame`` the robot's frame, and
    ``map_frame`` is another name of ``map``; ``tf_prefix`` is the prefix of frames that are named without one.

    Of gmapping: ``delta``, ``linearUpdate``, ``angularUpdate``, ``maxUrange``, ``occ_thresh`` and ``temporalUpdate``
    are other names, see `GMAPPING`; a negative ``temporalUpdate`` has no effect, as there.
    """

    max_key_frames: int = LIVE_KEY_FRAMES
    map_frame: str = MAP
    odom_frame: str = ""
    base_frame: str = BASE_LINK
    tf_prefix: str = ""
    throttle_scans: int = 1
    minimum_time_interval: float = 0.0
    map_update_interval: float = 5.0
    transform_publish_period: float = 0.05
    transform_timeout: float = 0.2
    min_pass_through: int = 2
    occupancy_threshold: float = 0.1
    do_loop_closing: bool = True
    paused_new_measurements: bool = False
    inf_is_valid: bool = False
    mode: Literal["mapping", "localization", "lifelong"] = "mapping"
    map_file_name: str = ""
    map_start_pose: tuple[float, float, float] | None = None
    lifelong_iou_match: float = 0.85
    lifelong_search_use_tree: bool | None = None
    lifelong_minimum_score: float | None = None
    lifelong_node_removal_score: float | None = None
    lifelong_overlap_score_scale: float | None = None
    lifelong_constraint_multiplier: float | None = None
    lifelong_nearby_penalty: float | None = None
    lifelong_candidates_scale: float | None = None
    loop_search_maximum_distance: float = 40.0
    loop_search_space_resolution: float = 0.1
    loop_search_space_smear_deviation: float = 0.1
    loop_match_minimum_response_coarse: float = 0.55
    loop_match_minimum_chain_size: int = 3
    delta: float | None = None
    linearUpdate: float | None = None  # noqa: N815  # gmapping's name
    angularUpdate: float | None = None  # noqa: N815
    maxUrange: float | None = None  # noqa: N815
    occ_thresh: float | None = None
    temporalUpdate: float | None = None  # noqa: N815

    def __post_init__(self) -> None:
        """Check the ranges."""
        # The parent would refuse gmapping's temporalUpdate of -1; its own parameters are checked by `front_end`.
        check_numbers(self, positive=_POSITIVE, signed=("temporalUpdate",))
        if self.occupancy_threshold > 1.0 or (self.occ_thresh or 0.0) > 1.0:
            raise InvalidParameter("occupancy_threshold, or occ_thresh, must be at most 1")
        if not all(map(math.isfinite, self.map_start_pose or ())):
            raise InvalidParameter(f"map_start_pose must be three finite numbers, not {self.map_start_pose}")
        if self.mode == "localization" and not self.map_file_name:
            raise InvalidParameter("mode 'localization' needs the name of a published map as map_file_name")
        self.front_end()
        self.closures()
        LifelongParameters(self.lifelong_iou_match)

    @property
    def unused(self) -> list[str]:
        """Names of the parameters given that have no effect."""
        return [name for name in WITHOUT_EFFECT if getattr(self, name) is not None]

    def frees(self, range_max: float) -> bool:
        """Return whether beams of a laser with a range [m] that hit nothing show free space."""
        return self.inf_is_valid or (self.maxUrange is not None and self.maxUrange < range_max)

    def lifelong(self) -> LifelongParameters | None:
        """Return the parameters of lifelong mapping; None in other modes."""
        return LifelongParameters(self.lifelong_iou_match) if self.mode == "lifelong" else None

    def front_end(self) -> SlamParameters:
        """Return the parameters of the front end.

        Raises
        ------
        InvalidParameter
            A value by a name of gmapping is out of range.
        """
        return SlamParameters(**{name: self._value(name) for name in SlamParameters.__struct_fields__})

    def closures(self) -> ClosureParameters | None:
        """Return the parameters of the search for closures; None if loops are not closed."""
        if not self.do_loop_closing:
            return None
        shared = set(ClosureParameters.__struct_fields__) & set(self.__struct_fields__)
        checked = max(CLOSURES.checked_scans, self.loop_match_minimum_chain_size)
        return ClosureParameters(checked_scans=checked, **{name: getattr(self, name) for name in shared})

    def drawing(self) -> DrawingSettings:
        """Return the settings of the map."""
        return DrawingSettings(*(self._value(name) for name in DrawingSettings._fields))

    def frames(self) -> FrameNames:
        """Return the names of the robot's frames."""
        return FrameNames.of(self.odom_frame, self.base_frame, self.map_frame, self.tf_prefix)

    @property
    def start_pose(self) -> Pose2D | None:
        """Pose of the robot on the map that is continued; None for the pose of its first key frame."""
        return None if self.map_start_pose is None else Pose2D(*self.map_start_pose)

    @property
    def least_interval(self) -> float:
        """Shortest time between two scans that are used [s]."""
        return max(0.0, float(self._value("minimum_time_interval")))

    def _value(self, name: str) -> Any:
        """Return a parameter, by gmapping's name if that is given."""
        values = [getattr(self, alias) for alias, of in GMAPPING.items() if of == name]
        given = [value for value in values if value is not None]
        return given[0] if given else getattr(self, name)


_POSITIVE = (
    "throttle_scans", "min_pass_through", "loop_search_maximum_distance", "loop_search_space_resolution",
    "loop_search_space_smear_deviation", "loop_match_minimum_chain_size", "delta", "linearUpdate", "angularUpdate",
    "maxUrange",
)  # fmt: skip
