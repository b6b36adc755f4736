"""Export of the spans of a process, and of the containers of a machine, to a receiver of OpenTelemetry."""
