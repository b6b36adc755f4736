"""What a caller may do on a robot follows from ownership, shares and the scope of the token."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from endpoints.accounts.tokens import ScopedUser
from endpoints.sharing.access import access_of
from engine.rights.access import CONFIGURING, READING, Access
from ppaas.errors import NotFound, NotPermitted, PPaaSError
from storage.records import User
from storage.sharing_records import ALL, SHARE_ROLES, Share, ShareRole, TokenRole, TokenScope

ANN, ROOT = User("ann", ""), User("root", "", "admin")
LOOK, DRIVE, ADMINISTER = (Share("bob", role, () if role == "look" else ALL) for role in SHARE_ROLES)


def access(*shares: Share, groups: tuple[str, ...] = ()) -> Access:
    return access_of(User("bob", "", groups=groups), "ann", "tb1", shares)


def scoped(
    role: TokenRole, *, publish: tuple[str, ...] = ALL, subscribe: tuple[str, ...] = ALL, user: str = "ann",
    robots: tuple[str, ...] = ("tb*",),
) -> ScopedUser:  # fmt: skip
    return ScopedUser(id=user, password_hash="", scope=TokenScope(robots, role, publish, subscribe))


def may(check: object, *arguments: object, **options: object) -> bool:
    try:
        check(*arguments, **options)  # type: ignore[operator]
    except NotPermitted:
        return False
    return True


def roles_of(found: Access) -> list[ShareRole]:
    return [role for role in SHARE_ROLES if may(found.check_role, role)]


@pytest.mark.parametrize("caller", [ANN, ROOT], ids=["owner", "administrator"])
def test_the_owner_and_administrators_may_do_everything(caller: User) -> None:
    found = access_of(caller, "ann", "tb1", ())
    assert found.is_full
    assert roles_of(found) == list(SHARE_ROLES)
    for as_robot in (True, False):
        found.check_connect(as_robot=as_robot)
    found.check_publish("cmd_vel")
    found.check_call("node_monitor/run_node")


@pytest.mark.parametrize("topics", [("tf",), ("*",), ("map",), ()])
def test_transforms_are_passed_on_to_those_who_may_hear_them(topics: tuple[str, ...]) -> None:
    found = access(Share("bob", "drive", ("*",), topics))
    hears = may(found.check_subscribe, "tf")
    assert may(found.check_goal, "tf2_web_republisher") == hears
    assert may(found.check_call, "republish_tfs") == hears
    assert may(found.check_goal, "move_base")


def test_zones_and_masks_of_the_map_are_read_like_the_map() -> None:
    for service in ("map_zones", "keepout_filter_mask", "speed_filter_mask"):
        assert may(access(LOOK).check_call, service)
        assert may(access(Share("bob", "drive", ("*",), (service,))).check_call, service)
        assert not may(access(Share("bob", "drive", ("*",), ("odom",))).check_call, service)


def test_a_robot_that_is_not_shared_is_unknown() -> None:
    for shares in ((), (Share("carl", "administer"),), (Share("group:bob", "look"), Share("group:hall", "look"))):
        with pytest.raises(NotFound, match="unknown robot 'ann:tb1'"):
            access(*shares)


@pytest.mark.parametrize(("share", "roles"), [(LOOK, 1), (DRIVE, 2), (ADMINISTER, 3)])
def test_each_role_includes_those_before_it(share: Share, roles: int) -> None:
    assert roles_of(access(share)) == list(SHARE_ROLES[:roles])


def test_members_of_a_group_have_what_is_shared_with_it_and_with_them() -> None:
    hall = Share("group:hall", "drive", ("cmd_vel",), ("odom",))
    found = access(hall, Share("bob", "look", (), ("map",)), groups=("hall",))
    assert roles_of(found) == ["look", "drive"]
    assert [topic for topic in ("odom", "map", "scan") if found.may_read(topic)] == ["odom", "map"]
    with pytest.raises(NotFound):
        access(hall, groups=("hal",))


def test_an_onlooker_reads_and_changes_nothing() -> None:
    found = access(LOOK)
    found.check_subscribe("people")
    for service in (*READING, "rosapi/topics"):
        found.check_call(service)
    for check, name in (
        (found.check_publish, "cmd_vel"),
        (found.check_goal, "move_base"),
        (found.check_call, "move_base/clear_costmaps"),
        (found.check_call, "navigate_to_pose/_action/cancel_goal"),
    ):
        with pytest.raises(NotPermitted, match="needs the role 'drive' on robot 'ann:tb1'; you have 'look'"):
            check(name)
    assert not may(found.check_connect, as_robot=True)
    found.check_connect(as_robot=False)


def test_a_driver_publishes_what_the_globs_permit() -> None:
    found = access(Share("bob", "drive", ("cmd_vel*", "move_base", "dock"), ("amcl_pose", "static_map")))
    assert [t for t in ("cmd_vel", "cmd_vel_stamped", "initialpose", "scan") if may(found.check_publish, t)] == [
        "cmd_vel", "cmd_vel_stamped",
    ]  # fmt: skip
    assert [t for t in ("amcl_pose", "map", "scan") if may(found.check_subscribe, t)] == ["amcl_pose"]
    assert [a for a in ("move_base", "follow_waypoints", "dock") if may(found.check_goal, a)] == ["move_base", "dock"]
    services = ("static_map", "dynamic_map", "dock", "dock/_action/cancel_goal", "undock", "rosapi/nodes")
    assert [s for s in services if may(found.check_call, s)] == [
        "static_map", "dock", "dock/_action/cancel_goal", "rosapi/nodes",
    ]  # fmt: skip
    with pytest.raises(NotPermitted, match="you may not publish 'initialpose' on robot 'ann:tb1'"):
        found.check_publish("initialpose")


def test_only_administrators_of_a_robot_configure_it_and_connect_as_it() -> None:
    for service in CONFIGURING:
        assert [may(access(share).check_call, service) for share in (LOOK, DRIVE, ADMINISTER)] == [False, False, True]
    for share in (LOOK, DRIVE, ADMINISTER):
        assert may(access(share).check_connect, as_robot=True) == (share is ADMINISTER)


def test_a_token_never_has_more_than_its_scope() -> None:
    found = access_of(scoped("drive", publish=("cmd_vel",), subscribe=("map",)), "ann", "tb1", ())
    assert not found.is_full
    assert roles_of(found) == ["look", "drive"]
    assert [t for t in ("cmd_vel", "initialpose") if may(found.check_publish, t)] == ["cmd_vel"]
    assert [t for t in ("map", "odom") if may(found.check_subscribe, t)] == ["map"]
    with pytest.raises(NotPermitted, match=r"needs the role 'administer' .* this token has 'drive': use another token"):
        found.check_role("administer")
    with pytest.raises(NotPermitted, match="this token may not publish 'initialpose'"):
        found.check_publish("initialpose")


def test_a_token_never_has_more_than_its_user() -> None:
    found = access_of(scoped("administer", user="bob", robots=("ann:*",)), "ann", "tb1", (LOOK,))
    assert roles_of(found) == ["look"]
    assert not may(found.check_publish, "cmd_vel")
    robot = access_of(scoped("robot", user="bob", robots=("ann:*",)), "ann", "tb1", (DRIVE,))
    assert not may(robot.check_connect, as_robot=True)


def test_a_token_for_other_robots_is_refused() -> None:
    with pytest.raises(NotPermitted, match=r"this token is for the robots tb\*, and not for 'kobuki'"):
        access_of(scoped("look"), "ann", "kobuki", ())
    with pytest.raises(NotPermitted):
        access_of(scoped("look", user="bob"), "ann", "tb1", (LOOK,))  # its robots are those of bob


def test_a_token_of_the_robot_itself_connects_as_the_robot_alone() -> None:
    found = access_of(scoped("robot"), "ann", "tb1", ())
    found.check_connect(as_robot=True)
    found.check_publish("scan")
    found.check_call("node_monitor/give_node")
    found.check_goal("move_base")
    assert roles_of(found) == ["look"]
    with pytest.raises(NotPermitted, match="connect with role=robot"):
        found.check_connect(as_robot=False)


def test_a_share_that_was_narrowed_does_not_include_the_one_before() -> None:
    narrow, wide = access(Share("bob", "drive", ("cmd_vel",))), access(DRIVE)
    assert wide.includes(narrow)
    assert not narrow.includes(wide)
    assert access(ADMINISTER).includes(wide)
    assert not access(LOOK).includes(narrow)
    assert Access.of_owner("tb1").includes(wide)
    assert not wide.includes(Access.of_owner("tb1"))
    assert not access_of(scoped("drive"), "ann", "tb1", ()).includes(Access.of_owner("tb1"))


globs = st.lists(st.sampled_from(["*", "a*", "cmd_vel", "map"]), max_size=2).map(tuple)
shares = st.lists(st.builds(Share, st.just("bob"), st.sampled_from(SHARE_ROLES), globs, globs), max_size=3)
scopes = st.none() | st.builds(
    TokenScope, st.just(("*:*",)), st.sampled_from(["look", "drive", "administer", "robot"]), globs, globs
)
names = st.sampled_from(["cmd_vel", "map", "a/b", "scan", "static_map", "node_monitor/run_node"])


def permitted(found: Access) -> set[tuple[str, str]]:
    checks = {
        "publish": found.check_publish, "subscribe": found.check_subscribe, "call": found.check_call,
        "goal": found.check_goal,
    }  # fmt: skip
    everything = ("cmd_vel", "map", "a/b", "scan", "static_map", "node_monitor/run_node", "move_base")
    return {(act, name) for act, check in checks.items() for name in everything if may(check, name)}


@given(shares, shares, scopes)
def test_what_includes_another_access_permits_all_that_it_permits(
    first: list[Share], second: list[Share], scope: TokenScope | None
) -> None:
    one, two = (Access("ann:tb1", tuple(given or [LOOK]), scope) for given in (first, second))
    if one.includes(two):
        assert permitted(one) >= permitted(two)


@given(shares, scopes)
def test_a_scope_only_takes_rights_away(given_shares: list[Share], scope: TokenScope | None) -> None:
    unscoped = Access("ann:tb1", tuple(given_shares or [LOOK]))
    limited = Access("ann:tb1", unscoped.grants, scope)
    if limited.is_for_the_robot:
        assert unscoped.role == "administer"
    else:
        assert permitted(limited) <= permitted(unscoped)
    assert set(roles_of(limited)) <= set(roles_of(unscoped))


def test_errors_of_rights_are_those_of_users() -> None:
    with pytest.raises(PPaaSError) as refused:
        access(LOOK).check_publish("cmd_vel")
    assert refused.value.slug == "not-permitted"
