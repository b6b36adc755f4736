"""Programs for the robot's computer: the base controller and the local node manager.

Each name is imported on first access, so a program that only drives motors does not load the node manager.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from robots.onboard.base_controller import BaseController, BaseLimits
    from robots.onboard.computer import this_computer
    from robots.onboard.local_nodes import run_local_nodes
    from robots.onboard.node_manager import LocalNodes

__all__ = ["BaseController", "BaseLimits", "LocalNodes", "run_local_nodes", "this_computer"]


def __getattr__(name: str) -> object:
    if name in ("BaseController", "BaseLimits"):
        from robots.onboard import base_controller  # noqa: PLC0415 - here and below: imported on first access

        return getattr(base_controller, name)
    if name == "this_computer":
        from robots.onboard.computer import this_computer  # noqa: PLC0415

        return this_computer
    if name == "run_local_nodes":
        from robots.onboard.local_nodes import run_local_nodes  # noqa: PLC0415

        return run_local_nodes
    if name == "LocalNodes":
        from robots.onboard.node_manager import LocalNodes  # noqa: PLC0415

        return LocalNodes
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
