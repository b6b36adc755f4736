"""A simulated rover that speaks MAVLink 2, as ArduPilot's and PX4's do."""
