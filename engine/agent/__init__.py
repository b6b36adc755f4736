"""TODO engine/agent."""
