"""The workpiece as it is at each moment: a race between flutes and what may not cut, on beams.

shapes_of_tools -> tool_items -> time_tree -> race (line_cuts, sweeps, solid_lines) -> rounds.
"""
