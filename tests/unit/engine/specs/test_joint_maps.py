"""Users whose robots may join their new maps."""

import pytest

from engine.specs.robot_maps import joint_map_owner
from storage.memory.maps import MemoryMapStore
from tests.support.storage.records import house, put_map


@pytest.mark.parametrize(
    ("readers", "owner"), [((), "bob"), (("bob",), "ann"), (("*",), "bob"), (("carl", "bob"), "ann")]
)
def test_new_maps_may_be_joined_with_those_of_the_owner_who_shares_the_published_one_by_name(readers, owner):
    maps = MemoryMapStore()
    put_map(maps, house("office-2", readers=readers))
    assert joint_map_owner(maps, "bob", "office-2") == owner
    assert joint_map_owner(maps, "ann", "office-2") == "ann"
    assert joint_map_owner(maps, "bob", "attic") == "bob"
