"""Commands of the command line, one file each; `turbine_fenicsx.cli.main` finds them here.

A command is a module with the docstring that `--help` shows, `arguments(parser)`, and
`run(options, comm)`, which returns the exit code. Modules import what is heavy only when they run.
With ``alone = True`` it also works where DOLFINx is missing; ``comm`` is then None.
Names with an underscore are no commands.
"""
