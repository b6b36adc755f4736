"""Local machine: starts, adopts and ends the agent of the computer that the web process runs on."""
