"""The domain of Path Planning as a Service: messages, maps, planners, controllers, nodes.

Nothing in this package does I/O: it has no socket, file, process or clock of its own, and all of it runs in a test
without a mock. Only planners have threads: `planners.field.tile_helpers` keeps helpers that sleep between searches, and
`planners.helper_threads` some that wait for slices of one search; those of `planners.batch.workers` end with the call.
Two modules look at what is installed: `plugins` at entry points, and `kernel_cache` at the source files of kernels. See
``docs/architecture.md``.
"""

__version__ = "0.2.0"
