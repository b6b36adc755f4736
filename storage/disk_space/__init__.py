"""Space on the disk of the local stores: measured, reserved for what must not fail, and refused to the rest."""
