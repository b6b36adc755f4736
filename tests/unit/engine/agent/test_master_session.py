"""Master session: when a machine acts for its cloud."""

from engine.agent.master_session import MasterSession
from engine.protocols import control_link
from tests.support.engine.engine_links import pair, receive


async def test_machine_acts_from_welcome_until_the_connection_ends() -> None:
    near, far = await pair(control_link.ToAgent, control_link.FromAgent)
    session = MasterSession(leased=False)
    session.tell(control_link.Exited("c0", 0))  # dropped: no master is connected
    assert not session.acts()
    session.begin(near)
    assert not session.acts() and session.lease is None
    session.welcome()
    assert session.acts()
    session.tell(control_link.Exited("c1", 0))
    assert await receive(far) == control_link.Exited("c1", 0)
    session.lost()
    assert not session.acts()
    session.begin(near)
    assert not session.acts()
    await near.close()
    await far.close()


async def test_machine_of_another_host_acts_while_its_lease_holds() -> None:
    near, far = await pair(control_link.ToAgent, control_link.FromAgent)
    session = MasterSession(leased=True)
    session.begin(near)
    assert session.lease is not None and session.lease.holds() and not session.acts()
    session.welcome()
    assert session.acts()
    session.lease.holds = lambda: False  # type: ignore[method-assign]
    assert not session.acts()
    await near.close()
    await far.close()
