"""Parameters of lifelong mapping, named as in slam_toolbox where one of theirs fits."""

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, check_numbers


class LifelongParameters(Parameters, frozen=True):
    """Parameters of lifelong mapping, in metres.

    Of slam_toolbox: a key frame is redundant if other ones show a part of ``lifelong_iou_match`` of its points.

    Others: the robot passes a place again after it has driven ``pass_distance``. The pose graph is thinned after
    ``least_new_frames`` new key frames, and at least an eighth of all.
    """

    lifelong_iou_match: float = 0.85
    pass_distance: float = 6.0
    least_new_frames: int = 32

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=("lifelong_iou_match", "pass_distance", "least_new_frames"))
        if self.lifelong_iou_match > 1.0:
            raise InvalidParameter(f"lifelong_iou_match must be at most 1, not {self.lifelong_iou_match}")
