"""Support of the tests of traffic."""
