"""Control of a cloud: executes the master's orders, feeds it events, and does what endpoints ask of the master."""
