"""What the recording of a robot costs."""
