"""What AGVs of VDA 5050 cost their bridge."""
