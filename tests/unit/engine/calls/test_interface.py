"""Objects whose methods are calls over a link."""

from collections.abc import Callable
from typing import Any, Protocol

import pytest

from engine.calls.interface import Method, method_of, notice, remote, wire_name
from ppaas.errors import PPaaSError, QuotaExceeded, Unavailable


class ShopCalls(Protocol):
    """Methods of a shop."""

    size = 7

    async def buy(self, item: str, count: int = 1, gift: bool = False) -> int: ...

    @notice
    async def ring(self, times: int) -> None: ...

    @wire_name("complain")
    async def refuse(self, reason: PPaaSError) -> PPaaSError: ...

    async def _steal(self) -> None: ...

    def price(self) -> int: ...


class Link:
    """Notes calls and notices."""

    def __init__(self) -> None:
        self.called: list[tuple[Any, ...]] = []
        self.told: list[tuple[Any, ...]] = []

    async def call(self, method: Callable[..., Any], /, *args: Any, **named: Any) -> Any:
        self.called.append((method, args, named))
        return len(self.called)

    def tell(self, method: Callable[..., Any], /, *args: Any, **named: Any) -> bool:
        self.told.append((method, args, named))
        return True


@pytest.fixture
def link() -> Link:
    return Link()


async def test_methods_are_calls_of_the_interface(link: Link) -> None:
    shop = remote(ShopCalls, link)
    assert [await shop.buy("tea"), await shop.buy("tea", 2, gift=True)] == [1, 2]
    assert link.called == [(ShopCalls.buy, ("tea",), {}), (ShopCalls.buy, ("tea", 2), {"gift": True})]


async def test_notices_are_not_waited_for(link: Link) -> None:
    await remote(ShopCalls, link).ring(3)
    assert (link.called, link.told) == ([], [(ShopCalls.ring, (3,), {})])


@pytest.mark.parametrize("name", ["sell", "_steal", "price", "size", "__len__"])
async def test_what_is_no_call_of_the_interface_is_no_attribute(link: Link, name: str) -> None:
    with pytest.raises(AttributeError, match="has no method"):
        getattr(remote(ShopCalls, link), name)


def test_names_on_the_wire_contain_the_interface() -> None:
    assert method_of(ShopCalls.buy).name == "ShopCalls.buy"
    assert method_of(ShopCalls.refuse).name == "complain"


@pytest.mark.parametrize(
    ("args", "named", "expected"),
    [
        (("tea",), {}, ("tea", 1, False)),
        (("tea",), {"gift": True}, ("tea", 1, True)),
        ((), {"count": 3, "item": "tea"}, ("tea", 3, False)),
        (("tea", 2, True), {}, ("tea", 2, True)),
    ],
)
def test_arguments_are_sent_in_the_order_of_the_method_with_its_defaults(
    args: tuple[Any, ...], named: dict[str, Any], expected: tuple[Any, ...]
) -> None:
    method = method_of(ShopCalls.buy)
    assert method.arguments.decode(method.packed(args, named)) == expected


def test_arguments_that_the_method_does_not_have_are_no_call() -> None:
    with pytest.raises(TypeError):
        method_of(ShopCalls.buy).packed(("tea",), {"colour": "green"})
    with pytest.raises(TypeError):
        method_of(ShopCalls.buy).packed((), {})


@pytest.mark.parametrize("error", [Unavailable("the robot left"), QuotaExceeded("too many", retry_after=2.5)])
def test_errors_are_passed_as_arguments_and_results(error: PPaaSError) -> None:
    method = method_of(ShopCalls.refuse)
    sent = method.packed((error,), {})
    [passed] = method.arguments.decode(sent)
    assert (type(passed), str(passed)) == (type(error), str(error))
    assert getattr(passed, "retry_after", None) == getattr(error, "retry_after", None)


def test_other_objects_cannot_be_passed() -> None:
    class Odd:
        async def take(self, odd: Link) -> None: ...

    with pytest.raises(NotImplementedError, match="cannot pass Link"):
        Method(Odd.take).packed((Link(),), {})
    with pytest.raises(NotImplementedError, match="cannot pass Link"):
        Method(Odd.take).arguments.decode(b"\x91\xc0")
