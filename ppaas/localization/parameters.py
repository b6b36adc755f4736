"""Parameters of localization, with the names of amcl."""

import math

from ppaas.errors import InvalidParameter
from ppaas.nodes.base import Parameters

MAX_PARTICLES = 100_000


class AmclParameters(Parameters, frozen=True):
    """Parameters of ``AmclNode`` and ``ParticleFilter``; metres, radians, seconds.

    Names are amcl's, and so are the defaults but for these: fewer particles, and 0.2 instead of 0.5 m around the start
    (a container is small, and a robot tells where it starts); updates after 0.1 m or 0.2 rad instead of 0.2 m or π/6
    (the pose drifts with the odometry between two updates); 60 beams instead of 30 and odometry noise of 0.1 instead of
    0.2, so that the pose is held to 0.1 m.
    """

    min_particles: int = 500
    max_particles: int = 2000
    kld_err: float = 0.01
    kld_z: float = 0.99
    update_min_d: float = 0.1
    update_min_a: float = 0.2
    resample_interval: int = 2
    laser_max_beams: int = 60
    laser_z_hit: float = 0.95
    laser_z_rand: float = 0.05
    laser_sigma_hit: float = 0.2
    laser_likelihood_max_dist: float = 2.0
    odom_alpha1: float = 0.1
    odom_alpha2: float = 0.1
    odom_alpha3: float = 0.1
    odom_alpha4: float = 0.1
    initial_cov_xx: float = 0.04
    initial_cov_yy: float = 0.04
    initial_cov_aa: float = 0.02
    transform_tolerance: float = 0.1
    seed: int = 0

    def __post_init__(self) -> None:
        """Check the ranges."""
        if not 1 <= self.min_particles <= self.max_particles <= MAX_PARTICLES:
            raise InvalidParameter(
                f"min_particles must be from 1 to max_particles, and that at most {MAX_PARTICLES}, "
                f"not {self.min_particles} and {self.max_particles}"
            )
        positive = ("kld_err", "laser_sigma_hit", "laser_likelihood_max_dist", "laser_max_beams", "resample_interval")
        negative_not = (
            "update_min_d", "update_min_a", "laser_z_hit", "laser_z_rand", "transform_tolerance", "seed",
            "odom_alpha1", "odom_alpha2", "odom_alpha3", "odom_alpha4",
            "initial_cov_xx", "initial_cov_yy", "initial_cov_aa",
        )  # fmt: skip
        for name in positive:
            if not 0 < getattr(self, name) < math.inf:
                raise InvalidParameter(f"{name} must be above 0 and finite, not {getattr(self, name)}")
        for name in negative_not:
            if not 0 <= getattr(self, name) < math.inf:
                raise InvalidParameter(f"{name} must be finite and not negative, not {getattr(self, name)}")
