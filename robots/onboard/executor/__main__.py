"""Entry point ``python -m robots.onboard.executor``: the process of the local nodes."""

from robots.onboard.executor.local_executor import main

main()
