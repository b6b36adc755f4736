"""The domain of Path Planning as a Service: messages, maps, planners, controllers, nodes.

Nothing in this package does I/O. It opens no socket, file, process or thread; all of it runs in a test without
a mock. See ``docs/architecture.md``.
"""

__version__ = "0.1.0"
