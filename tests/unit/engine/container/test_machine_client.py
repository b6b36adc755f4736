"""The container's end of the machine link."""

import asyncio
from collections.abc import AsyncIterator

import pytest

from engine.container.machine_client import MachineClient
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import Refusal
from ppaas.errors import NotPermitted, Unavailable
from tests.support.engine.engine_links import pair, receive

Machine = FrameStream[machine_link.FromContainer]


@pytest.fixture
async def ends() -> AsyncIterator[tuple[MachineClient, Machine, list[machine_link.Shared]]]:
    near, far = await pair(machine_link.ToContainer, machine_link.FromContainer)
    client, heard = MachineClient(near), list[machine_link.Shared]()
    serving = asyncio.create_task(client.serve(lambda *messages: heard.extend(messages)))
    yield client, far, heard
    await far.close()
    await asyncio.wait_for(serving, 10)
    await client.close()


Ends = tuple[MachineClient, Machine, list[machine_link.Shared]]


async def test_answers_are_matched_to_requests_in_any_order(ends: Ends) -> None:
    client, machine, _ = ends
    saves = [asyncio.create_task(client.save_clone({"n": bytes([n])})) for n in range(3)]
    frames = [await receive(machine) for _ in saves]
    assert [frame.nodes for frame in frames] == [{"n": bytes([n])} for n in range(3)]
    machine.write(machine_link.Done(frames[2].request))
    machine.write(machine_link.Done(12345))
    machine.write(machine_link.Done(frames[0].request, Refusal("not-permitted", "no")))
    await asyncio.wait_for(saves[2], 10)
    with pytest.raises(NotPermitted, match="no"):
        await asyncio.wait_for(saves[0], 10)
    assert not saves[1].done()
    machine.write(machine_link.Done(frames[1].request))
    await asyncio.wait_for(saves[1], 10)


async def test_unanswered_request_raises_unavailable(ends: Ends, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.container.machine_client.REQUEST_TIMEOUT", 0.05)
    client, machine, _ = ends
    with pytest.raises(Unavailable):
        await client.save_clone({})
    late = await receive(machine)
    machine.write(machine_link.Done(late.request))  # too late: no request waits for it
    saving = asyncio.create_task(client.save_clone({}))
    machine.write(machine_link.Done((await receive(machine)).request))
    await saving


async def test_index_request_has_no_request_timeout(ends: Ends, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.container.machine_client.REQUEST_TIMEOUT", 0.0)
    client, machine, _ = ends
    preparing = asyncio.create_task(client.prepare_index("hub_labels"))
    frame = await receive(machine)
    assert (type(frame), frame.planner) == (machine_link.PrepareIndex, "hub_labels")
    machine.write(machine_link.Done(frame.request))
    await preparing


async def test_resize_and_new_endpoint_are_passed_to_the_callbacks() -> None:
    near, far = await pair(machine_link.ToContainer, machine_link.FromContainer)
    client, notified = MachineClient(near), list[int | str]()
    serving = asyncio.create_task(client.serve(lambda _: None, notified.append, lambda: notified.append("an endpoint")))
    far.write(machine_link.Resized(2))
    far.write(machine_link.EndpointCame())
    await far.close()
    await asyncio.wait_for(serving, 10)
    assert notified == [2, "an endpoint"]
    await client.close()


async def test_shared_messages_are_passed_to_the_callback(ends: Ends) -> None:
    client, machine, heard = ends
    messages = [machine_link.Shared(user, "tb1", "amcl_pose", b"{}") for user in ("ann", "bob", "eve")]
    machine.write(messages[0])
    machine.write(machine_link.SharedBatch(messages[1:]))
    saving = asyncio.create_task(client.save_clone({}))
    machine.write(machine_link.Done((await receive(machine)).request))
    await saving
    assert heard == messages
