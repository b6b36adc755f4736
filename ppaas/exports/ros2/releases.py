"""Releases of ROS 2, and the names in which Nav2 and slam_toolbox differ between them.

Sources: the migration guides of https://docs.nav2.org, and ``nav2_params.yaml`` of each release.
"""

from enum import Enum


class Release(Enum):
    """Release of ROS 2, whose Nav2 a set-up is for."""

    HUMBLE = "humble"
    JAZZY = "jazzy"
    KILTED = "kilted"
    ROLLING = "rolling"

    @property
    def is_humble(self) -> bool:
        """Whether names are of Nav2 1.1, before those that all later releases have."""
        return self is Release.HUMBLE

    def plugin(self, package: str, name: str) -> str:
        """Return the type of a planner or a behaviour: ``nav2_behaviors::Spin``, in Humble with a slash."""
        return f"{package}{'/' if self.is_humble else '::'}{name}"

    @property
    def full_speed(self) -> str:
        """Parameter of the pure pursuit controller that is its speed in free space."""
        return "max_linear_vel" if self is Release.ROLLING else "desired_linear_vel"

    @property
    def obstacle_critic(self) -> str:
        """Critic of MPPI that keeps off obstacles."""
        return "ObstaclesCritic" if self.is_humble else "CostCritic"

    @property
    def tree(self) -> str:
        """First tag of a behaviour tree, which names the version of its format from Jazzy on."""
        return "<root>" if self.is_humble else '<root BTCPP_format="4">'


ABSENT: dict[str, frozenset[Release]] = {
    "FollowPath.use_fixed_curvature_lookahead": frozenset({Release.HUMBLE}),
    "FollowPath.curvature_lookahead_dist": frozenset({Release.HUMBLE}),
    "FollowPath.ax_max": frozenset({Release.HUMBLE}),
    "FollowPath.ax_min": frozenset({Release.HUMBLE}),
    "FollowPath.az_max": frozenset({Release.HUMBLE}),
    "GridBased.allow_primitive_interpolation": frozenset({Release.HUMBLE}),
}
"""Parameters that some releases do not have yet."""
