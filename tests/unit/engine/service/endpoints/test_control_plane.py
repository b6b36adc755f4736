"""Parts of the master have the methods of their Protocols, in the product as in the fake of the tests."""

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import get_type_hints

import pytest

from engine.calls.interface import methods_of
from engine.service.endpoints.control_plane import ControlPlane, MasterParts
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.master_cloud import MasterCloud


@pytest.fixture(params=[MasterCloud, lambda _: FakeCloud()], ids=["product", "fake"])
async def cloud(request: pytest.FixtureRequest, tmp_path: Path) -> ControlPlane:
    make: Callable[[Path], ControlPlane] = request.param
    return make(tmp_path)


@pytest.mark.parametrize(("name", "interface"), get_type_hints(MasterParts).items())
async def test_a_part_has_the_methods_of_its_protocol(cloud: ControlPlane, name: str, interface: type) -> None:
    part = getattr(cloud, name)
    methods = methods_of(interface)
    assert methods
    for method in methods:
        expected = inspect.signature(getattr(interface, method.attribute)).parameters
        found = inspect.signature(getattr(part, method.attribute)).parameters
        assert ["self", *found] == list(expected), method.name


def test_no_two_methods_have_one_name_on_the_wire() -> None:
    names = [method.name for part in get_type_hints(MasterParts).values() for method in methods_of(part)]
    assert len(names) == len(set(names)) > 30
