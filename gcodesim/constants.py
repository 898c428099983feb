"""Every tolerance of gcodesim: its unit, its usual value and what breaks when it changes."""

from __future__ import annotations

PS_PER_S = 1_000_000_000_000
"""Picoseconds per second. Program time is an int64 count of picoseconds: it is never accumulated in
floating point, so it is equal for every chunking. The range is 9.2e6 s; longer ones are GC424."""

MAX_TIME_PS = 9_000_000_000_000_000_000
"""Longest program time [ps], just below the range of int64 (104 days)."""

DEFAULT_PERIOD_PS = 100_000_000
"""Sample period [ps]: 0.1 ms, the seed paper's sample time. Larger values step over thin parts."""

MIN_PERIOD_PS, MAX_PERIOD_PS = 1_000_000, 10 * PS_PER_S
"""Shortest and longest sample period [ps]: 1 us and 10 s. Below, programs have too many samples to
be counted in a contact's key; above, nothing is sampled that a machine does."""

SNAP_MM = 2.0**-33
"""Grid [mm] that posed vertices are rounded to (1.2e-10 mm). On the grid, differences of
coordinates below 2^20 mm are exact, which bounds false alarms to a clearance of 26 u D. Moving a
vertex by at most 1.0e-10 mm, it is far below any tolerance of a machine."""

CERTIFICATE_ULPS = 12.0
"""A projected gap separates two triangles only when it exceeds this many unit roundoffs of its own
magnitude sum. Below 8.02 the proof that no contact is missed fails (see predicates.py)."""

CERTIFICATE_FLOOR = 1.0e-300
"""Absolute part of the same bound [axis units x mm]: covers underflow, also when it is flushed."""

RANGE_GUARD = 1.0e70
"""Sum of coordinates [mm] above which products might overflow; such a pair counts as contact."""

BOX_SLACK_MM = 1.0e-8
"""Boxes are widened by this [mm] before they may separate: covers the rounding of posed boxes and
the snapping of vertices. Larger only costs time; smaller than 1e-9 could hide a touch."""

SLACK_MM = 1.0e-9
"""Distances are good to this [mm]: pose rounding, snapping and the certified test together."""

TOLERANCE_MM = 1.0e-3
"""Distance [mm] below which an interval between two samples no longer counts as proved free."""

MAX_BLOCKS = 100_000_000
"""Blocks after which interpretation ends unless told otherwise, some 20 GB of moves."""

MAX_REPEATED_BLOCKS = 5_000_000
"""Blocks beyond the lines of all texts, so repeated by loops, calls and cycles, after which
interpretation ends unless told otherwise: endless loops end within a minute and some 1.3 GB. An
honest program of more is told how to raise it."""

TRAVEL_SLACK = 1.0e-6
"""Travel may be exceeded by this without a finding, by a linear joint [mm] and a rotary one [deg]:
programs with three decimals that end exactly on a limit must not fail through rounding."""

CLEARANCE_SLACK_MM = 1.0e-6
"""A clearance may be missed by this [mm] without a finding: a plate at exactly that distance keeps
it, and no search proves more than a limit that is just reached."""

FULL_CIRCLE_MM = 1.0e-9
"""An arc whose end lies this near its start [mm] along the arc is a full circle. Programs have 4
decimals; rounding of machine coordinates stays below 1e-11 mm."""

TCP_DEVIATION_MM = 1.0e-3
"""Moves under tool centre point control are cut into pieces straight in the joints; no point of a
link leaves the true path by more than this [mm], and pairs keep that distance. Smaller makes more
pieces (as the inverse square root), larger widens every pair."""
