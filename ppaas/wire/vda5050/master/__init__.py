"""Master control of VDA 5050 without I/O: leads one AGV along paths by orders, and checks what it says."""
