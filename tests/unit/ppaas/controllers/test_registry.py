import pytest

from ppaas.controllers import controller_names, create
from ppaas.controllers.dwa import DynamicWindow
from ppaas.errors import InvalidParameter, NotFound


@pytest.mark.parametrize("name", ["dwa", "dwa_local_planner/DWAPlannerROS", "base_local_planner/TrajectoryPlannerROS"])
def test_controller_is_created_by_its_own_or_ros_name(name):
    controller = create(name, max_vel_x=0.3)
    assert isinstance(controller, DynamicWindow)
    assert controller.parameters.max_vel_x == 0.3


@pytest.mark.parametrize(
    "name",
    [
        "regulated_pure_pursuit",
        "nav2_regulated_pure_pursuit_controller/RegulatedPurePursuitController",
        "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController",
    ],
)
def test_pure_pursuit_has_nav2_names(name):
    assert create(name).name == "pure_pursuit"


def test_unknown_name_error_lists_the_known_names():
    with pytest.raises(NotFound, match=r"unknown controller 'nonsense'; known: .*dwa"):
        create("nonsense")


@pytest.mark.parametrize("wrong", [{"horn": 1.0}, {"max_vel_x": -1.0}, {"max_vel_x": "fast"}])
def test_invalid_parameter_is_refused_by_name(wrong):
    with pytest.raises(InvalidParameter, match=next(iter(wrong))):
        create("dwa", **wrong)


def test_installed_controllers_state_their_name_and_purpose():
    assert "dwa" in controller_names()
    for name in controller_names():
        assert create(name).name == name
        assert create(name).purpose
