"""Maps that robots continue, and users whose robots may join their new maps."""

import pytest

from engine.specs.containers import MapVersion
from engine.specs.robot_maps import continued_map, joint_map_owner
from ppaas.errors import InvalidParameter
from storage.memory.maps import MemoryMapStore
from tests.support.storage.records import house, put_map


@pytest.fixture
def maps():
    store = MemoryMapStore()
    put_map(store, house("office", posegraph=b"graph", readers=("bob",)))
    put_map(store, house("bare"))
    return store


def parameters(name):
    return {"grid_slam": {"map_file_name": name}}


def test_the_head_version_of_the_map_is_continued(maps):
    version = maps.map_head("office").version
    for user in ("ann", "bob"):
        assert continued_map(maps, user, parameters("office")) == MapVersion("office", version)


@pytest.mark.parametrize("given", [{}, {"grid_slam": {}}, {"grid_slam": []}, parameters(""), parameters(3)])
def test_without_a_name_a_new_map_begins(maps, given):
    assert continued_map(maps, "ann", given) is None


def test_a_map_without_a_pose_graph_is_refused(maps):
    with pytest.raises(InvalidParameter, match="has no pose graph"):
        continued_map(maps, "ann", parameters("bare"))


def test_unknown_maps_and_those_of_others_are_refused_alike(maps):
    for user, name in (("carl", "office"), ("ann", "garden")):
        with pytest.raises(InvalidParameter, match="is not a published map"):
            continued_map(maps, user, parameters(name))


@pytest.mark.parametrize(
    ("readers", "owner"), [((), "bob"), (("bob",), "ann"), (("*",), "bob"), (("carl", "bob"), "ann")]
)
def test_new_maps_may_be_joined_with_those_of_the_owner_who_shares_the_published_one_by_name(readers, owner):
    maps = MemoryMapStore()
    put_map(maps, house("office-2", readers=readers))
    assert joint_map_owner(maps, "bob", "office-2") == owner
    assert joint_map_owner(maps, "ann", "office-2") == "ann"
    assert joint_map_owner(maps, "bob", "attic") == "bob"
