"""Variants of a costmap and of planners, for requests with their own parameters."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import msgspec

from ppaas.costmap.costmap import Costmap
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.planners.base import Planner
from ppaas.plans.reuse.processor import PlanProcessor

if TYPE_CHECKING:
    from ppaas.planners.batch.path_lengths import PathLengths

Given = Mapping[str, Any]
"""Parameters of a request, by name: its planner's and the global costmap's."""


class Variant(NamedTuple):
    """Costmap of the map alone for some parameters, and the processor that finds stored plans for it."""

    costmap: Costmap
    processor: PlanProcessor


class Variants(Protocol):
    """Makes what a request with parameters plans with. Planning threads call it, one at a time."""

    def planner(self, name: str, given: Given) -> Planner:
        """Return a planner with these parameters, which only the requests of one queue may use.

        Raises
        ------
        NotFound
            There is no such planner.
        InvalidParameter
            A parameter is unknown or invalid; the text lists those that exist.
        """
        ...

    def allows_unknown(self, given: Given) -> bool:
        """Return whether costs of paths lead through unknown cells; raises as ``planner`` does."""
        ...

    def lengths(self, given: Given, threads: int, check: Callable[[], None]) -> "PathLengths | None":
        """Return what measures lengths of paths if these parameters ask for lengths; raises as ``planner`` does."""
        ...

    def variant(self, given: Given) -> Variant:
        """Return the costmap for these parameters, which may have to be made first; raises as ``planner`` does."""
        ...


class NoVariants:
    """Variants of a robot, which plans with the parameters of its file."""

    def planner(self, name: str, given: Given) -> Planner:
        """Raise ``InvalidParameter``."""
        raise self._refusal()

    def allows_unknown(self, given: Given) -> bool:
        """Raise ``InvalidParameter``."""
        raise self._refusal()

    def lengths(self, given: Given, threads: int, check: Callable[[], None]) -> "PathLengths | None":
        """Raise ``InvalidParameter``."""
        raise self._refusal()

    def variant(self, given: Given) -> Variant:
        """Raise ``InvalidParameter``."""
        raise self._refusal()

    @staticmethod
    def _refusal() -> InvalidParameter:
        return InvalidParameter("a robot plans with the parameters of its file: change them there")


NO_VARIANTS = NoVariants()
"""Variants of a robot."""


def parameters_of(text: str) -> dict[str, Any]:
    """Return the parameters in a request's JSON, of which empty text is ``{}``.

    Raises
    ------
    InvalidInput
        The text is not a JSON object.
    """
    try:
        return from_json(text, dict[str, Any]) if text else {}
    except (msgspec.DecodeError, RecursionError) as error:
        raise InvalidInput(f"parameters must be a JSON object: {error}") from error
