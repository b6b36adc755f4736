"""Parameter files of gmapping: a robot that makes a map by ``grid_slam``, which knows gmapping's names."""

from typing import TYPE_CHECKING

from ppaas.imports.parameters.known_names import apply_known, values_of_node
from ppaas.imports.parameters.launch_files import read_parameters
from ppaas.imports.parameters.ros_yaml import GivenValue
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, put, same, without_effect
from ppaas.imports.parameters.slam.slam_toolbox_rules import LEAST_TRAVEL, STEP
from ppaas.imports.parameters.values import at_least, frame
from ppaas.imports.report import ImportReport
from ppaas.maps.new_map import NEW

if TYPE_CHECKING:
    from ppaas.imports.parameters.draft import Translation

_SLAM = "parameters.grid_slam."

_PARTICLES = "a pose graph takes the place of particles"
_GROWS = "the map grows with what the robot sees"
_MATCHER = "scans are aligned with key frames by their lines; there is no such term"


RULES: ParameterRules = {
    **same(
        _SLAM, "delta", "maxUrange", "temporalUpdate", "srr", "srt", "str", "stt", "map_update_interval",
        "transform_publish_period",
    ),
    **same(_SLAM, "odom_frame", "map_frame", "base_frame", convert=frame),
    "throttle_scans": ParameterRule(_SLAM + "throttle_scans", "at least 1", at_least(1, int)),
    "linearUpdate": ParameterRule(_SLAM + "linearUpdate", STEP, at_least(LEAST_TRAVEL)),
    "angularUpdate": ParameterRule(_SLAM + "angularUpdate", STEP, at_least(LEAST_TRAVEL)),
    "occ_thresh": ParameterRule(_SLAM + "occ_thresh"),
    "tf_delay": ParameterRule(_SLAM + "transform_timeout"),
    "maxRange": ParameterRule(text="the range of the laser is that of its scans; maxUrange bounds what is used"),
    **without_effect(_PARTICLES, "particles", "resampleThreshold", "seed"),
    **without_effect(_GROWS, "xmin", "ymin", "xmax", "ymax"),
    **without_effect(
        _MATCHER, "sigma", "kernelSize", "lstep", "astep", "iterations", "lsigma", "ogain", "lskip", "minimumScore",
        "llsamplerange", "llsamplestep", "lasamplerange", "lasamplestep",
    ),
    "inverted_laser": ParameterRule(text="a laser that is upside down is known by its transform"),
    "scan_topic": ParameterRule(text="the bridge of the robot, or its client, sends its scans as 'scan'"),
}  # fmt: skip
"""Rules of gmapping."""


def import_gmapping(content: bytes, name: str, new_map: str = "map") -> "Translation":
    """Translate a parameter file of gmapping, or a launch file, into a part of a robot file: the robot makes a map.

    Parameters
    ----------
    content : bytes
    name : str
        Name of the file, for the report.
    new_map : str
        Id under which the map is to be published that the robot makes.

    Raises
    ------
    InvalidParameter
        The file cannot be read as parameters.
    """
    into: Translation = ({}, ImportReport(name))
    report = into[1]
    node, given = values_of_node(read_parameters(content, report), lambda each: "gmapping" in each, report)
    apply_gmapping(given, node, into, new_map)
    return into


def apply_gmapping(given: dict[str, GivenValue], node: str, into: "Translation", new_map: str) -> None:
    """Apply the rules of gmapping to the parameters of its node: the robot makes a map."""
    put(into[0], "map", NEW + new_map)
    apply_known(RULES, given, node, into)
