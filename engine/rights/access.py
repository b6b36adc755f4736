"""Access of a caller to a robot: the one place that decides what the caller may do on it, topic by topic."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal

from engine.rights.globs import matches
from ppaas.errors import NotPermitted
from ppaas.wire import rosapi
from ppaas.wire.actions import CANCEL_GOAL
from storage.sharing_records import ALL, SHARE_ROLES, Share, ShareRole, TokenScope

# -- services by the right that they need ------------------------------------------------------------------------------

READING = frozenset(
    {
        "compute_costs",
        "compute_fleet_plan",
        "compute_packed_path",
        "compute_path",
        "dynamic_map",
        "keepout_filter_mask",
        "make_plan",
        "map_zones",
        "move_base/compute_path",
        "move_base/make_plan",
        "node_monitor/list_nodes",
        "octomap_binary",
        "octomap_full",
        "octomap_server/file",
        "people_coordinator/get_people",
        "people_coordinator/get_people_counts",
        "pose_graph",
        "recorder/state",
        "rosapi/get_param",
        "rosapi/get_param_names",
        "rosapi/has_param",
        "rosapi/search_param",
        "speed_filter_mask",
        "static_map",
        "traffic/get_traffic",
    }
)
"""Services that change nothing of the robot and its clone."""

PASSED_ON = {"tf2_web_republisher": "tf", "republish_tfs": "tf"}
"""Actions and services whose feedback or stream has the content of a topic."""

CONFIGURING = frozenset(
    {
        "node_monitor/give_node",
        "node_monitor/hold_node",
        "node_monitor/run_node",
        "node_monitor/tell_robot",
        "people_coordinator/configure_people",
        "rosapi/delete_param",
        "rosapi/set_param",
        "traffic/let_go",
        "traffic/put_back",
        "traffic/take_out",
    }
)
"""Services that change what the clone consists of, its parameters, or what its group does."""


def lists_names(service: str) -> bool:
    """Return whether a service only lists names and types of the graph, which all clients of a robot may see."""
    return service in rosapi.SERVICES


def only_reads(service: str) -> bool:
    """Return whether a service changes nothing."""
    return service in READING


def passed_on(name: str) -> str:
    """Return the topic whose content an action or a service passes on; empty if there is none."""
    return PASSED_ON.get(name, "")


def configures(service: str) -> bool:
    """Return whether a service configures the clone of a robot."""
    return service in CONFIGURING


# -- access ------------------------------------------------------------------------------------------------------------

Act = Literal["publish", "call", "send a goal to"]

_LEVELS = {role: level for level, role in enumerate(SHARE_ROLES)}

OWNED = Share("", "administer", ALL, ALL)
"""Rights of the owner of a robot, and of administrators."""

_ROBOT = "robot"


@dataclass(frozen=True, slots=True)
class Access:
    """Rights of a caller on one robot.

    Parameters
    ----------
    robot : str
        Address of the robot, for errors.
    grants : tuple of Share
        Shares that apply; what one of them permits is permitted.
    scope : TokenScope, optional
        Scope of the caller's token, which must permit it too.
    """

    robot: str
    grants: tuple[Share, ...]
    scope: TokenScope | None = None

    @classmethod
    def of_owner(cls, robot: str) -> "Access":
        """Return the rights of the owner of a robot, whose address this is."""
        return cls(robot, (OWNED,))

    @property
    def is_full(self) -> bool:
        """Whether it has all rights of an owner."""
        return self.scope is None and OWNED in self.grants

    @property
    def role(self) -> ShareRole:
        """Role of the caller on the robot; of a token for the robot itself, look."""
        granted = max((share.role for share in self.grants), key=_LEVELS.__getitem__)
        return granted if self.scope is None else min(granted, _share_role(self.scope), key=_LEVELS.__getitem__)

    @property
    def is_for_the_robot(self) -> bool:
        """Whether the token is for the robot itself."""
        return self.scope is not None and self.scope.role == _ROBOT and self._grants_role("administer")

    def includes(self, other: "Access") -> bool:
        """Return whether it permits all that another access permits, as far as a comparison of globs shows."""
        if self.is_full:
            return True
        return self.scope == other.scope and all(
            any(_includes(share, theirs) for share in self.grants) for theirs in other.grants
        )

    # -- checks --------------------------------------------------------------------------------------------------------

    def check_role(self, role: ShareRole) -> None:
        """Raise ``NotPermitted`` unless the caller has a role on the robot."""
        if _LEVELS[self.role] < _LEVELS[role]:
            raise self._lacks_role("this", role)

    def check_connect(self, *, as_robot: bool) -> None:
        """Raise ``NotPermitted`` unless the caller may open a socket as the robot itself, or as an operator."""
        if as_robot and not self.is_for_the_robot:
            self.check_role("administer")
        if not as_robot and self.is_for_the_robot:
            raise NotPermitted(f"this token is for robot {self.robot!r} itself: connect with role=robot")

    def check_publish(self, topic: str) -> None:
        """Raise ``NotPermitted`` unless the caller may publish a topic."""
        if not self.is_full:
            self._check_act("publish", topic, (topic,))

    def check_subscribe(self, topic: str) -> None:
        """Raise ``NotPermitted`` unless the caller may subscribe to a topic."""
        if not self.is_full and not self.may_read(topic):
            raise self._lacks_name("subscribe to", topic)

    def check_call(self, service: str) -> None:
        """Raise ``NotPermitted`` unless the caller may call a service; what only reads needs no more than look."""
        if self.is_full or lists_names(service):
            return
        if only_reads(service):
            if not self.may_read(service):
                raise self._lacks_name("call", service)
            return
        if service.endswith(CANCEL_GOAL):
            self.check_goal(service.removesuffix(CANCEL_GOAL))
            return
        if configures(service) and not self.is_for_the_robot:
            self.check_role("administer")
        self._check_act("call", service, (service,))
        self._check_passed_on(service)

    def check_goal(self, action: str) -> None:
        """Raise ``NotPermitted`` unless the caller may send goals to an action, and cancel them."""
        if not self.is_full:
            self._check_act("send a goal to", action, (action, f"{action}/goal"))
            self._check_passed_on(action)

    def may_read(self, name: str) -> bool:
        """Return whether the caller may subscribe to a topic, or call a service of this name that only reads."""
        return any(matches(name, share.subscribe) for share in self.grants) and (
            self.scope is None or matches(name, self.scope.subscribe)
        )

    @property
    def readable(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Globs of topics that shares permit, and globs that the token permits: `may_read` needs one of each."""
        shared = tuple(glob for share in self.grants for glob in share.subscribe)
        return shared, ("*",) if self.scope is None else tuple(self.scope.subscribe)

    # -- internals -----------------------------------------------------------------------------------------------------

    def _check_passed_on(self, name: str) -> None:
        if topic := passed_on(name):
            self.check_subscribe(topic)

    def _grants_role(self, role: ShareRole) -> bool:
        return any(_LEVELS[share.role] >= _LEVELS[role] for share in self.grants)

    def _check_act(self, act: Act, name: str, spellings: Collection[str]) -> None:
        if not self.is_for_the_robot and _LEVELS[self.role] < _LEVELS["drive"]:
            raise self._lacks_role(f"to {act} {name!r}", "drive")
        granted = any(_permits(share.publish, spellings) for share in self.grants)
        if not granted or not (self.scope is None or _permits(self.scope.publish, spellings)):
            raise self._lacks_name(act, name)

    def _lacks_role(self, doing: str, role: ShareRole) -> NotPermitted:
        if self._grants_role(role):
            return NotPermitted(
                f"{doing} needs the role {role!r} on robot {self.robot!r}; this token has {self._token_role!r}: use "
                "another token"
            )
        return NotPermitted(
            f"{doing} needs the role {role!r} on robot {self.robot!r}; you have {self.role!r}: ask its owner for more"
        )

    def _lacks_name(self, act: str, name: str) -> NotPermitted:
        of = "this token" if self.scope is not None else "you"
        return NotPermitted(f"{of} may not {act} {name!r} on robot {self.robot!r}: it is not among the names shared")

    @property
    def _token_role(self) -> str:
        return "" if self.scope is None else self.scope.role


def _share_role(scope: TokenScope) -> ShareRole:
    return "look" if scope.role == "robot" else scope.role


def _permits(globs: Collection[str], spellings: Collection[str]) -> bool:
    return any(matches(spelling, globs) for spelling in spellings)


def _includes(share: Share, other: Share) -> bool:
    return _LEVELS[share.role] >= _LEVELS[other.role] and all(
        "*" in ours or set(ours) >= set(theirs)
        for ours, theirs in ((share.publish, other.publish), (share.subscribe, other.subscribe))
    )
