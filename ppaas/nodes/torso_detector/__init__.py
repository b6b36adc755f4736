"""Node ``torso_detector``."""
