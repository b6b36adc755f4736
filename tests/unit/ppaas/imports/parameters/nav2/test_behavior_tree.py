"""Behaviour trees give the rate of planning and the recoveries, in the order in which they are tried."""

import pytest

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.clone_check import refusal
from ppaas.imports.parameters.nav2.behavior_tree import MAX_TREE, Tree, as_behaviors, default_tree, read_tree
from ppaas.imports.parameters.nav2.importer import import_nav2
from ppaas.imports.report import ImportOutcome

NAVIGATION = """
<root main_tree_to_execute="Main">
  <BehaviorTree ID="Unused"><Wait wait_duration="99"/></BehaviorTree>
  <BehaviorTree ID="Main">
    <RecoveryNode number_of_retries="{retries}">
      <PipelineSequence>
        <RateController hz="2.0">
          <RecoveryNode number_of_retries="1">
            <ComputePathToPose goal="{{goal}}" path="{{path}}"/>
            <GoalUpdated/>
          </RecoveryNode>
        </RateController>
        <FollowPath path="{{path}}"/>
      </PipelineSequence>
      {recovery}
    </RecoveryNode>
  </BehaviorTree>
  <BehaviorTree ID="Turns"><Spin spin_dist="{{angle}}"/></BehaviorTree>
</root>
"""

ROBIN = """<ReactiveFallback><GoalUpdated/><RoundRobin{0}>
  <Sequence><ClearEntireCostmap/><ClearEntireCostmap/></Sequence>
  <Spin spin_dist="1.2"/><BackUp backup_dist="0.2" backup_speed="0.1"/>
</RoundRobin></ReactiveFallback>"""


def tree(recovery: str, retries: int = 5) -> Tree:
    return read_tree(NAVIGATION.format(retries=retries, recovery=recovery).encode())


def names(read: Tree) -> list[str]:
    return [each.name for each in read.recoveries]


def test_a_round_robin_is_tried_once_for_each_retry() -> None:
    read = tree(ROBIN.format(""))
    assert names(read) == ["clear_costmaps", "spin", "backup", "clear_costmaps", "spin"]
    assert read.rate == 2.0
    assert read.recoveries[1].parameters == {"spin_dist": 1.2}
    assert read.recoveries[2].parameters == {"backup_dist": 0.2, "backup_speed": 0.1, "time_allowance": 10.0}
    assert read.others == ("PipelineSequence", "GoalUpdated", "FollowPath", "ReactiveFallback", "Sequence")


def test_a_round_robin_that_does_not_wrap_tries_each_once() -> None:
    assert names(tree(ROBIN.format(' wrap_around="false"'))) == ["clear_costmaps", "spin", "backup"]


def test_a_sequence_is_tried_as_a_whole() -> None:
    recovery = '<Sequence><ClearCostmapExceptRegion reset_distance="2"/><Wait wait_duration="3"/></Sequence>'
    read = tree(recovery, retries=2)
    assert names(read) == ["clear_costmaps", "wait", "clear_costmaps", "wait"]
    assert read.recoveries[0].parameters == {"reset_distance": 2.0}


def test_recoveries_with_other_parameters_have_other_names() -> None:
    read = tree('<RoundRobin><Spin spin_dist="1.0"/><Spin spin_dist="-1.0"/></RoundRobin>', retries=3)
    assert names(read) == ["spin", "spin_2", "spin"]
    assert as_behaviors(read.recoveries)[1] == {"name": "spin_2", "type": "rotate_recovery"}


def test_recoveries_outside_the_recovery_node_are_not_taken() -> None:
    stuck = "<Sequence><IsStuck/><Spin/><ClearEntireCostmap/></Sequence>"
    read = read_tree(f"<root><BehaviorTree ID='Main'>{stuck}</BehaviorTree></root>".encode())
    assert read.recoveries == ()
    assert read.others == ("Sequence", "IsStuck", "Spin", "ClearEntireCostmap")


def test_subtrees_and_explicit_nodes_are_read_and_ports_of_the_blackboard_have_defaults() -> None:
    read = tree('<RoundRobin><SubTree ID="Turns"/><Action ID="Wait" wait_duration="4"/></RoundRobin>', retries=2)
    assert names(read) == ["spin", "wait"]
    assert read.recoveries[0].parameters == {"spin_dist": 1.57}


def test_a_tree_that_plans_once_has_no_rate() -> None:
    once = b"<root><BehaviorTree ID='a'><Sequence><ComputePathToPose/><FollowPath/></Sequence></BehaviorTree></root>"
    assert read_tree(once) == Tree(0.0, (), ("Sequence", "FollowPath"))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"<root>", "no XML"),
        (b"\xff\xfe\x00", "no XML"),
        (b"<root/>", "no element <BehaviorTree>"),
        (b'<!DOCTYPE r [<!ENTITY a "b">]><root/>', "entities"),
        (b" " * (MAX_TREE + 1), "at most"),
        (b"<root><BehaviorTree ID='a'>" + b"<a/>" * 10_000 + b"</BehaviorTree></root>", "at most 10000 nodes"),
    ],
)
def test_other_files_are_refused(content: bytes, words: str) -> None:
    with pytest.raises(InvalidParameter, match=words):
        read_tree(content)


def test_subtrees_that_contain_themselves_and_doubling_ones_end() -> None:
    inner = "".join(
        f"<BehaviorTree ID='t{i}'><SubTree ID='t{i + 1}'/><SubTree ID='t{i + 1}'/></BehaviorTree>" for i in range(40)
    )
    with pytest.raises(InvalidParameter, match="at most"):
        read_tree(f"<root>{inner}</root>".encode())
    loop = b"<root><BehaviorTree ID='a'><SubTree ID='a'/></BehaviorTree></root>"
    assert read_tree(loop).recoveries == ()


def test_the_tree_of_a_robot_replaces_the_default_recoveries() -> None:
    text = b"behavior_server:\n  ros__parameters: {max_rotational_vel: 0.5}\n"
    draft, _ = import_nav2(text, "nav2.yaml")
    listed = draft["parameters"]["move_base"]["recovery_behaviors"]
    assert listed == as_behaviors(default_tree().recoveries)
    assert draft["parameters"]["spin"] == {"max_rotational_vel": 0.5, "spin_dist": 1.57}
    own = NAVIGATION.format(retries=1, recovery='<Wait wait_duration="3"/>').encode()
    draft, report = import_nav2(text, "nav2.yaml", tree=own)
    assert draft["parameters"] == {
        "move_base": {"planner_frequency": 2.0, "recovery_behaviors": [{"name": "wait", "type": "wait"}]},
        "wait": {"wait_duration": 3.0},
    }
    assert refusal({"map": "office", **draft}) is None
    (idle,) = [entry for entry in report.entries if entry.part == "behavior_server.max_rotational_vel"]
    assert (idle.outcome, idle.text) == (ImportOutcome.NO_EFFECT, "no recovery of the robot is spin")


def test_parameters_of_the_server_are_for_all_recoveries_of_their_kind() -> None:
    server = b"behavior_server:\n  ros__parameters: {max_rotational_vel: 0.7, simulate_ahead_time: 1.5}\n"
    robin = (
        '<RoundRobin><Spin spin_dist="1.2"/><Spin spin_dist="-1.2"/><BackUp/><BackUp backup_dist="0.4"/></RoundRobin>'
    )
    draft, _ = import_nav2(server, "nav2.yaml", tree=NAVIGATION.format(retries=4, recovery=robin).encode())
    tables = draft["parameters"]
    assert tables["spin"] == {"max_rotational_vel": 0.7, "spin_dist": 1.2}
    assert tables["spin_2"] == {"max_rotational_vel": 0.7, "spin_dist": -1.2}
    assert [tables[name]["simulate_ahead_time"] for name in ("backup", "backup_2")] == [1.5, 1.5]
    assert tables["backup_2"]["backup_dist"] == 0.4
    assert refusal({"map": "new:room", **draft}) is None


def test_behaviors_that_a_server_lacks_are_no_recoveries() -> None:
    draft, _ = import_nav2(
        b"behavior_server:\n  ros__parameters: {behavior_plugins: [wait], wait.plugin: nav2_behaviors/Wait}\n", "n"
    )
    kinds = [each["name"] for each in draft["parameters"]["move_base"]["recovery_behaviors"]]
    assert kinds == ["clear_costmaps", "wait", "clear_costmaps"]
