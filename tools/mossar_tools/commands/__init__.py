"""Sub-commands, one module each; `mossar_tools.cli` imports only the module of the given command.

A command module has `DESCRIPTION` and `EXAMPLES` (help texts), `add_arguments(parser)` and
`run(options, console) -> int`, which returns the exit status.
"""
