"""Steps between two nodes of a pose graph with their covariance, inverted and joined to first order."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.planar_poses import PoseArray, compose, inverse


class UncertainStep(NamedTuple):
    """Measured pose of a node in the frame of another.

    Parameters
    ----------
    measurement : (3,) array
        x, y [m], theta [rad].
    covariance : (3, 3) array
        In the frame of the other node.
    """

    measurement: PoseArray
    covariance: NDArray[np.float64]

    @property
    def information(self) -> NDArray[np.float64]:
        """Inverse of the covariance, symmetric."""
        found = np.asarray(np.linalg.inv(self.covariance), np.float64)
        return 0.5 * (found + found.T)

    @property
    def spread(self) -> float:
        """Sum of the variances of the position [m²]."""
        return float(self.covariance[0, 0] + self.covariance[1, 1])

    def inverted(self) -> "UncertainStep":
        """Return the step back."""
        x, y, theta = self.measurement
        c, s = np.cos(theta), np.sin(theta)
        jacobian = np.array([(-c, -s, s * x - c * y), (s, -c, c * x + s * y), (0.0, 0.0, -1.0)])
        return UncertainStep(inverse(self.measurement), jacobian @ self.covariance @ jacobian.T)

    def then(self, other: "UncertainStep") -> "UncertainStep":
        """Return this step followed by another one, whose error does not depend on that of this one."""
        theta, (x, y, _) = self.measurement[2], other.measurement
        c, s = np.cos(theta), np.sin(theta)
        of_this = np.array([(1.0, 0.0, -s * x - c * y), (0.0, 1.0, c * x - s * y), (0.0, 0.0, 1.0)])
        of_other = np.array([(c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)])
        covariance = of_this @ self.covariance @ of_this.T + of_other @ other.covariance @ of_other.T
        return UncertainStep(compose(self.measurement, other.measurement), covariance)
