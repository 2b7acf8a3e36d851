"""Sub-commands, one module each; `mossar_tools.cli` imports the one that is asked for.

A command module has `DESCRIPTION` and `EXAMPLES` (help texts), `add_arguments(parser)` and
`run(options, console) -> int`, which returns the exit status.
"""
