"""Torso IDs: kept by a track, different at any time, and used again only after many others."""

from hypothesis import given
from hypothesis import strategies as st

from ppaas.people.tracks.robot_tracker import MOST, TorsoIds


@given(
    st.lists(st.sets(st.integers(1, 400), max_size=30), max_size=20),
    st.sets(st.sampled_from(["12", "torso_1", "torso_2"])),
)
def test_tracks_have_different_ids_that_they_keep(steps, taken):
    ids: TorsoIds = TorsoIds()
    before: dict[int, str] = {}
    for tracks in steps:
        ids.keep(tracks)
        names = {track: ids.of(track, taken=taken) for track in sorted(tracks)}
        assert len(set(names.values())) == len(names)
        assert taken.isdisjoint(names.values())
        assert all(before.get(track, name) == name for track, name in names.items())
        before = names


def test_id_is_not_used_again_at_once():
    ids, names = TorsoIds(), []
    for track in range(MOST + 1):
        names.append(ids.of(track))
        ids.keep(())
    assert len(set(names[:MOST])) == MOST
    assert names[MOST] == names[0] == "torso_1"


def test_more_tracks_than_ids_have_ids_too():
    ids = TorsoIds()
    assert len({ids.of(track) for track in range(MOST + 50)}) == MOST + 50


def test_id_that_the_robot_gave_is_taken_unless_another_track_has_it():
    ids = TorsoIds()
    assert [ids.of(1, "17"), ids.of(2, "17"), ids.of(1, "18")] == ["17", "torso_1", "17"]


def test_restored_ids_go_on():
    ids, other = TorsoIds(), TorsoIds()
    ids.of(4)
    other.restore(ids.state())
    assert [other.of(4), other.of(5)] == ["torso_1", "torso_2"]
