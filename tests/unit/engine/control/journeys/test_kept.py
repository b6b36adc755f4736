"""Journeys and rides of a building, as they are stored."""

from engine.control.journeys.kept import KeptJourneys, keep_journeys, kept_journeys, record_name
from ppaas.buildings.journeys.records import Journey, JourneyLeg
from ppaas.buildings.lifts.states import LiftRide
from storage.memory.store import MemoryStore

LEG = JourneyLeg(kind="lift", floor="L1", to_floor="L2", start=(1.0, 2.0, 0.0), goal=(3.0, 4.0, 0.5), name="north")
JOURNEY = Journey(
    id="journey-1", user="ann", robot="tb1", building="hotel", floor="L2", goal=(1.0, 2.0, 3.0), on="L1", legs=(LEG,)
)
RIDE = LiftRide(robot="ann/tb1", lift="north", origin="L1", destination="L2", phase="inside")


def test_what_was_kept_is_found_by_owner_and_building_until_nothing_is_left() -> None:
    store = MemoryStore()
    assert kept_journeys(store, "ann", "hotel") == KeptJourneys()
    keep_journeys(store, ("ann", "hotel"), [JOURNEY], [RIDE], 100.0)
    assert kept_journeys(store, "ann", "hotel") == KeptJourneys((JOURNEY,), (RIDE,))
    assert kept_journeys(store, "bob", "hotel") == kept_journeys(store, "ann", "mall") == KeptJourneys()
    keep_journeys(store, ("ann", "hotel"), [], [RIDE], 101.0)
    assert kept_journeys(store, "ann", "hotel").rides == (RIDE,)
    keep_journeys(store, ("ann", "hotel"), [], [], 102.0)
    assert kept_journeys(store, "ann", "hotel") == KeptJourneys()
    assert record_name("hotel") != record_name("mall")
