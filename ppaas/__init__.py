"""The domain of Path Planning as a Service: messages, maps, planners, controllers, nodes.

Nothing in this package does I/O: it opens no sockets, files or processes and takes time from `ppaas.clock` only, so all
of it can be tested without mocks. Only planners start threads: threads of `planners.field.tile_helpers` sleep between
searches, threads of `planners.helper_threads` wait for slices of one search, and threads of `planners.batch.workers`
end with the call. Two modules read the installation: `plugins` reads entry points, and `kernel_cache` the source files
of the kernels and those that were compiled elsewhere. See ``docs/architecture.md``.
"""

__version__ = "0.2.0"
