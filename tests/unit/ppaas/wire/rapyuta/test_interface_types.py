"""Types of interfaces and joins."""

import itertools

import pytest

from ppaas.errors import InvalidInput
from ppaas.wire.rapyuta.interface_types import TYPES, check_joinable, interface_type


def test_there_are_four_roles_in_three_forms() -> None:
    roles, forms = (
        ("ServiceClient", "ServiceProvider", "Publisher", "Subscriber"),
        ("Interface", "Converter", "Forwarder"),
    )
    assert set(TYPES) == {"".join(parts) for parts in itertools.product(roles, forms)}
    assert all(str(interface_type(name)) == name for name in TYPES)


@pytest.mark.parametrize("name", ["", "Publisher", "Interface", "publisherInterface", "ServiceInterface", "PublisherX"])
def test_other_types_are_refused_with_those_that_exist(name: str) -> None:
    with pytest.raises(InvalidInput, match="ServiceClient, ServiceProvider"):
        interface_type(name)


def test_publishers_join_subscribers_and_clients_join_providers() -> None:
    pairs = {"Publisher": "Subscriber", "Subscriber": "Publisher"}
    pairs |= {"ServiceClient": "ServiceProvider", "ServiceProvider": "ServiceClient"}
    for names in itertools.product(TYPES, TYPES):
        one, other = ((interface_type(name), "std_msgs/String") for name in names)
        if pairs[one[0].role] == other[0].role:
            check_joinable(one, other)
        else:
            with pytest.raises(InvalidInput, match="Can not connect"):
                check_joinable(one, other)


def test_different_classes_do_not_join() -> None:
    one, other = interface_type("PublisherInterface"), interface_type("SubscriberConverter")
    with pytest.raises(InvalidInput, match="different classes"):
        check_joinable((one, "std_msgs/String"), (other, "std_msgs/Bool"))
