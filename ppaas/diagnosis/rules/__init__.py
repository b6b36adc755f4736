"""Rules of the diagnosis: functions from observations to findings."""
