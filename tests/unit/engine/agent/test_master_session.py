"""Master session: when a machine acts for its cloud."""

from engine.agent.master_session import MasterSession
from engine.protocols import control_link
from tests.support.engine.engine_links import pair, receive


async def test_machine_acts_from_welcome_until_the_connection_ends() -> None:
    near, far = await pair(control_link.ToAgent, control_link.FromAgent)
    session = MasterSession(remote=False)
    session.tell(control_link.Exited("c0", 0))  # dropped: no master is connected
    assert not session.acts()
    session.begin(near)
    assert not session.acts()
    assert session.welcome(0)
    assert session.acts()
    session.tell(control_link.Exited("c1", 0))
    assert await receive(far) == control_link.Exited("c1", 0)
    session.lost()
    assert not session.acts()
    session.begin(near)
    assert not session.acts()
    await near.close()
    await far.close()


async def test_machine_acts_while_its_lease_holds() -> None:
    near, far = await pair(control_link.ToAgent, control_link.FromAgent)
    session = MasterSession(remote=True)
    session.begin(near)
    assert session.lease.holds() and not session.acts()
    assert session.welcome(0)
    assert session.acts()
    session.lease.holds = lambda: False  # type: ignore[method-assign]
    assert not session.acts()
    await near.close()
    await far.close()


async def test_containers_may_be_replaced_unless_their_master_shows_that_nobody_leads() -> None:
    near, far = await pair(control_link.ToAgent, control_link.FromAgent)
    session = MasterSession(remote=True)
    assert session.may_be_replaced(), "no master is connected"
    session.begin(near)
    session.welcome(0)
    assert not session.may_be_replaced(), "the machine acts"
    lease = session.lease
    lease.holds = lambda: False  # type: ignore[method-assign]
    assert session.may_be_replaced()
    lease.nobody_leads = lambda: True  # type: ignore[method-assign]
    assert not session.may_be_replaced() and not session.acts()
    session.lost()
    assert session.may_be_replaced()
    await near.close()
    await far.close()


async def test_machine_follows_later_masters_and_refuses_an_earlier_one() -> None:
    session = MasterSession(remote=True)
    for epoch, accepted in ((3, True), (3, True), (5, True), (4, False), (5, True)):
        near, far = await pair(control_link.ToAgent, control_link.FromAgent)
        session.begin(near)
        assert session.welcome(epoch) is accepted is session.acts() is not session.refused
        if not accepted:
            assert await receive(far) == control_link.Outranked(5), "it is told why"
        await near.close()
        await far.close()
