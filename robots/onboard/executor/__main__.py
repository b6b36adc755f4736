"""``python -m robots.onboard.executor`` is the process of local nodes."""

from robots.onboard.executor.local_executor import main

main()
