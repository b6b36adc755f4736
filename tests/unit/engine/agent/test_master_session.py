"""Master session: when a machine acts for its cloud."""

from engine.agent.master_session import MasterSession
from engine.protocols import control_link
from tests.support.engine.engine_links import pair, receive


async def test_a_machine_acts_from_a_welcome_to_the_end_of_its_connection() -> None:
    near, far = await pair(control_link.ToAgent, control_link.FromAgent)
    standing = MasterSession(leased=False)
    standing.tell(control_link.Exited("c0", 0))  # dropped: no master is connected
    assert not standing.acts()
    standing.begin(near)
    assert not standing.acts() and standing.lease is None
    standing.welcome()
    assert standing.acts()
    standing.tell(control_link.Exited("c1", 0))
    assert await receive(far) == control_link.Exited("c1", 0)
    standing.lost()
    assert not standing.acts()
    standing.begin(near)
    assert not standing.acts()
    await near.close()
    await far.close()


async def test_one_of_another_host_acts_while_its_lease_holds() -> None:
    near, far = await pair(control_link.ToAgent, control_link.FromAgent)
    standing = MasterSession(leased=True)
    standing.begin(near)
    assert standing.lease is not None and standing.lease.holds() and not standing.acts()
    standing.welcome()
    assert standing.acts()
    standing.lease.holds = lambda: False  # type: ignore[method-assign]
    assert not standing.acts()
    await near.close()
    await far.close()
