"""Node ``people_tracker``: tracks the people that a robot sees, and reports them to the coordinator."""
