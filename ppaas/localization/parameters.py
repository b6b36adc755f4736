"""Parameters of localization, named as in amcl."""

import math
from typing import Literal

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters

MAX_PARTICLES = 100_000

LaserModel = Literal["likelihood_field", "likelihood_field_prob", "beam"]
OdomModel = Literal["diff", "omni", "diff-corrected", "omni-corrected"]


class AmclParameters(Parameters, frozen=True):
    """Parameters of ``AmclNode`` and ``ParticleFilter``, in metres, radians and seconds.

    Names and defaults are amcl's, with these exceptions:

    - fewer particles, and a standard deviation of 0.2 m instead of 0.5 m around the start: a container is small, and a
      robot states where it starts;
    - updates after 0.1 m or 0.2 rad instead of 0.2 m or π/6: between updates the pose drifts with the odometry;
    - 60 beams instead of 30;
    - the corrected odometry model, whose noise is a standard deviation, with 0.02 instead of 0.2: odometry is better
      than that, and the pose is tracked more closely.

    If ``laser_min_range`` or ``laser_max_range`` is negative, the value of the scan is used. ``odom_alpha5`` is for
    robots that drive sideways. The robot is searched for on the whole map if the fit of its scans, averaged with
    ``recovery_alpha_fast``, falls a tenth below the average with ``recovery_alpha_slow``; 0 disables this.

    ``odom_drift`` is not amcl's: the standard deviation of the heading of the odometry per second, whether the robot
    moves or not [rad/s]. The errors of amcl's models belong to a motion.

    ``localize`` is not amcl's either: whether ``AmclNode`` localizes the robot. It is false for a robot that localizes
    itself, and may send scans for its costmap.

    ``odom_frame_id`` is by default the frame that the odometry names. ``base_frame_id`` is the frame in which the robot
    is driven; wherever the odometry names another one, the two are joined. ``global_frame_id`` is another name of the
    frame ``map``. ``tf_prefix`` is the prefix of frames that are named without one.
    """

    min_particles: int = 500
    max_particles: int = 2000
    kld_err: float = 0.01
    kld_z: float = 0.99
    update_min_d: float = 0.1
    update_min_a: float = 0.2
    resample_interval: int = 2
    recovery_alpha_slow: float = 0.001
    recovery_alpha_fast: float = 0.1
    laser_model_type: LaserModel = "likelihood_field"
    laser_min_range: float = -1.0
    laser_max_range: float = -1.0
    laser_max_beams: int = 60
    laser_z_hit: float = 0.95
    laser_z_short: float = 0.1
    laser_z_max: float = 0.05
    laser_z_rand: float = 0.05
    laser_sigma_hit: float = 0.2
    laser_lambda_short: float = 0.1
    laser_likelihood_max_dist: float = 2.0
    odom_model_type: OdomModel = "diff-corrected"
    odom_alpha1: float = 0.02
    odom_alpha2: float = 0.02
    odom_alpha3: float = 0.02
    odom_alpha4: float = 0.02
    odom_alpha5: float = 0.02
    odom_drift: float = 0.002
    localize: bool = True
    initial_cov_xx: float = 0.04
    initial_cov_yy: float = 0.04
    initial_cov_aa: float = 0.02
    transform_tolerance: float = 0.1
    tf_broadcast: bool = True
    odom_frame_id: str = ""
    base_frame_id: str = "base_link"
    global_frame_id: str = "map"
    tf_prefix: str = ""
    seed: int = 0

    def __post_init__(self) -> None:
        """Check the ranges."""
        if not 1 <= self.min_particles <= self.max_particles <= MAX_PARTICLES:
            raise InvalidParameter(
                f"min_particles must be from 1 to max_particles, and max_particles at most {MAX_PARTICLES}, "
                f"not {self.min_particles} and {self.max_particles}"
            )
        for name in _POSITIVE:
            if not 0 < getattr(self, name) < math.inf:
                raise InvalidParameter(f"{name} must be above 0 and finite, not {getattr(self, name)}")
        for name in _NOT_NEGATIVE:
            if not 0 <= getattr(self, name) < math.inf:
                raise InvalidParameter(f"{name} must be finite and not negative, not {getattr(self, name)}")
        self._check_ranges()
        self._check_recovery()

    def _check_ranges(self) -> None:
        least, most = self.laser_min_range, self.laser_max_range
        if not (math.isfinite(least) and math.isfinite(most)) or most == 0.0 or 0.0 < most <= least:
            raise InvalidParameter(
                f"laser_min_range must be below laser_max_range, or one of them negative, not {least} and {most}"
            )

    def _check_recovery(self) -> None:
        slow, fast = self.recovery_alpha_slow, self.recovery_alpha_fast
        if not (slow == fast == 0.0 or slow < fast <= 1.0):
            raise InvalidParameter(
                "recovery_alpha_slow must be below recovery_alpha_fast, which is at most 1, or both must be 0, "
                f"not {slow} and {fast}"
            )


_POSITIVE = (
    "kld_err", "laser_sigma_hit", "laser_lambda_short", "laser_likelihood_max_dist", "laser_max_beams",
    "resample_interval",
)  # fmt: skip
_NOT_NEGATIVE = (
    "update_min_d", "update_min_a", "transform_tolerance", "seed", "kld_z",
    "laser_z_hit", "laser_z_short", "laser_z_max", "laser_z_rand",
    "odom_alpha1", "odom_alpha2", "odom_alpha3", "odom_alpha4", "odom_alpha5", "odom_drift",
    "initial_cov_xx", "initial_cov_yy", "initial_cov_aa", "recovery_alpha_slow", "recovery_alpha_fast",
)  # fmt: skip
