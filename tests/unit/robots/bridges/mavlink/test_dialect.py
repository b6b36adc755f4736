"""Parser of MAVLink: a message with a wrong signature changes nothing."""

from robots.bridges.mavlink.dialect import Parser, mavlink

KEY, OTHER_KEY = bytes(range(32)), bytes(32)


def test_a_wrongly_signed_message_leaves_what_is_known_of_its_sender() -> None:
    station, vehicle, other = Parser(255, KEY), Parser(1, KEY), Parser(1, OTHER_KEY)
    beat = mavlink.MAVLink_heartbeat_message(10, 3, 0, 0, 4, 3)
    assert len(station.read(vehicle.write(beat))) == 1
    known = dict(station.signing.stream_timestamps)
    assert station.read(other.write(beat)) == []
    assert (station.forged, dict(station.signing.stream_timestamps)) == (1, known)
    assert known
