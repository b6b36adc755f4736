"""Bridge of rovers that speak MAVLink: ArduPilot and PX4."""
