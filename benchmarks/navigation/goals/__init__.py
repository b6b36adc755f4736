"""The goals bench: a simulated robot is sent to goals among pedestrians; reached goals and contacts are counted."""
