"""Navigation: Move Base as a pure state machine, events in and orders out."""
