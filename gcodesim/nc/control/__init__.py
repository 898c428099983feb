"""Meaning: what a control can be told, whatever the language, and what it then does.

In the order in which they build on each other: `supply` and `readings` (what is known before a
program starts), `place`, `modal`, `frames` (levels) and `state` (what is known between two lines),
then the actions: `moves`, `corners`, `drilling`, `five_axes`, `tool_changes`, `orders`. Around them
stand `program_flow` (which line runs next), `columns` with `plain_run`, `hole_run` and `runs` (many
lines at once), `language_base` (what a language is asked) and `interpreter` (which asks it).
"""
