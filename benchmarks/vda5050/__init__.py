"""Cost of AGVs of VDA 5050 for their bridges."""
