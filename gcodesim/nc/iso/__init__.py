"""ISO programs as Fanuc, Haas and LinuxCNC read them: characters to actions of the control.

`reader` takes a block through its steps: `lexer` (words), `words` (the one table of codes) and
`checks` (the block as a whole), then the actions that `actions` names: `motion`, `cycles`,
`offsets`, `planes`, `tooling`, `tables`, `modes`, `calls`. Macro text is read by `statements` and
`expressions` and carried out by `macros`; `structure` and `jumps` find where it goes on.
"""
