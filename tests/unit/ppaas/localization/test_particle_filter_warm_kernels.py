import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.localization.kernels import cluster, likelihood_field, motion, resample
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.particle_filter import ParticleFilter
from ppaas.maps.grid import GridInfo, GridMap


@pytest.mark.parametrize(
    ("module", "kernel"),
    [
        (likelihood_field, likelihood_field.score_serial),
        (motion, motion.move_diff_serial),
        (resample, resample.draw_low_variance),
        (resample, resample.kld_sample_size),
        (cluster, cluster.heaviest_bin),
        (cluster, cluster.moments_around),
    ],
)
def test_warm_kernel_compiles_no_more_signatures_in_use(module, kernel):
    module.warm()
    warm = list(kernel.signatures)
    parameters = AmclParameters(min_particles=10, max_particles=10, resample_interval=1)
    info = GridInfo(0.05, 20, 20)
    grid = GridMap(np.eye(20, dtype=np.int8) * 100, info)
    localization = ParticleFilter(build_layers(grid), parameters)
    for x in (0.0, 0.5):
        localization.update(Pose2D(x, 0, 0), np.array([[0.1, 0.2]]), 8.0)
    assert kernel.signatures == warm
