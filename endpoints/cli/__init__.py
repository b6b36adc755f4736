"""Commands of the server side. Each module has NAME, HELP, ``configure(parser)`` and ``run(arguments)``."""
