"""Every tolerance that decides a verdict: its unit, its value and what breaks when it changes.

Numbers that decide none (of geometry, drawing, speed, or that another control prescribes) stand
where they are used; tests/test_constants.py lists each of them with its reason.
"""

from __future__ import annotations

PS_PER_S = 1_000_000_000_000
"""Picoseconds per second. Program time is an int64 count of picoseconds: it is never accumulated in
floating point, so it is equal for every chunking. The range is 9.2e6 s; longer ones are GC424."""

LONGEST_S = 9.0e6
"""Longest program time [s], 104 days: just below the range of int64 in picoseconds. A program that
takes longer is GC424."""

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

CROSSING_SLACK_MM = 1.0e-6
"""Two triangles that cross are taken to go on crossing while they may move by this [mm] more: it
covers the rounding of poses and heights. Smaller than 1e-7 could call a free instant a contact."""

TOLERANCE_MM = 1.0e-3
"""Distance [mm] below which an interval between two samples no longer counts as proved free."""

MAX_BLOCKS = 100_000_000
"""Blocks after which interpretation ends unless told otherwise, some 20 GB of moves."""

MAX_REPEATED_BLOCKS = 5_000_000
"""Blocks beyond the lines of all texts, so repeated by loops, calls and cycles, after which
interpretation ends unless told otherwise: endless loops end within a minute and some 1.3 GB. The
finding says how to raise it."""

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

# What the distances of pairs are good for.

DISTANCE_GOOD_TO_MM = 5.0e-7
"""A smallest distance is found to this [mm]; finer costs time with the square root, and most where
faces are parallel."""

AUDIT_GOOD_TO_MM = 1.0e-6
"""A margin of what was left out is confirmed when it holds to this [mm]: twice what distances are
good to. Smaller calls rounding a disagreement (GC901)."""

MINIMUM_KNOWN_PART = 1.0e-3
"""The smallest distance over time is known to this part of it, and its time is when the pair first
comes within this part of it: where a pair stays at one distance for long, finer costs a hundred
times as much."""

FOUND_AGAIN_MM = 1.0e-6
"""What is added to the distance for its time [mm]: smaller, and rounding may lose the time."""

DEPTH_SLACK = 0.02
"""What was accepted counts again where it is deeper by more than this than when it was accepted
[mm, deg], and a depth is looked for until no more can hide [mm]. Smaller lets edits elsewhere fail,
larger accepts what nobody has seen."""

# Files of a machine.

LARGEST_NUMBER = 1.0e9
"""Largest number of a machine, tools, setup or mesh file, in any unit: beyond it squares of lengths
lose the micrometre."""

UNIT_RATIO = 20.0
"""A mesh this many times smaller or larger than the longest linear travel, and than all bodies of
its link and tool, is in the wrong unit if another one fits (GC503). Smaller suspects bolts."""

THIN_TRIANGLE = 1.0e-12
"""Twice a triangle's area over its longest edge squared; below this it counts as degenerate
(GC504). Larger calls the slivers of honest meshes faulty."""

TOUCHING_MM = 1.0e-6
"""A gap between flute and holder up to this [mm] needs no shank between them; smaller asks for one
(GC421) because of rounding."""

CORNER_RADIUS_SLACK = 1.0e-9
"""The rounded corner of a cutter may reach beyond its axis by this part of its radius. Smaller
refuses ball ends because of rounding."""

STOCK_INSET_MM = 0.05
"""How deep a tool part may be in what is left of the stock before it is a contact [mm], unless the
setup says otherwise. Smaller, and the chords of a CAM system alarm; larger hides a touch."""

LEAST_INSET_MM = 0.005
"""Smallest inset that is accepted [mm]: beams grow as its inverse, and none is without beams."""

WITNESS_OVERLAP_MM = 1.0e-3
"""A witness lies in body and stock along this much of a line at least [mm]. Smaller lets rounding
be a contact; what is thinner stays undecided."""

FLUTE_INSET_MM = 0.05
"""By how much a flute is smaller, along its radius and its axis, where it may not touch the part
[mm]. Smaller, and a retract along a finished wall is a contact by the tolerance of the CAM system;
larger, and a rapid that deep in the part is not seen."""

FLUTE_SIDES = 96
"""Sides of the polygon inside the smaller flute. Fewer, and its flats lie more than 0.06 % of the
radius inside the circle."""

ROUND_SIDES = 12
"""A mesh counts as a flute about the spindle axis where no section is less round than a polygon of
so many sides. More refuses coarse meshes, fewer would leave more of a corner unseen."""

SAME_HEIGHT_MM = 1.0e-7
"""Corners whose heights differ by less lie in one section of a flute [mm]: so much is rounding.
Smaller cuts a tilted flute into slivers; larger takes a short stretch of it for none."""

MOST_SECTIONS = 500
"""A flute with corners at more heights is no turned profile, but a scan or helical edges: beyond it
nothing is gained but time."""

# Rotary axes and tool centre point control.

SINGULAR_VOLUME = 1.0e-6
"""Slides whose directions span less than this volume cannot place a tip; rotary axes at a smaller
sine of their angle cannot point a tool. Smaller would let slides run a million times as far."""

LEAST_VOLUME = 1.0e-3
"""Slides that may span less volume somewhere in a stretch have no bound there: they all but lie in
one plane, and would have to run a thousand times as far as the tip."""

RIGHT_ANGLE_COSINE = 1.0e-12
"""Slides whose directions have cosines below this stand at right angles. Larger would bound a
skewed machine as if it were square."""

REACH_SLACK = 1.0e-12
"""Directions this far outside the cone that a pair of axes reaches count as on its edge (square of
a sine). Larger would turn tools beyond what was programmed."""

ONE_AXIS_SLACK_RAD = 1.0e-6
"""A machine with one rotary axis may miss a direction by this [rad]: I J K have 6 digits. Smaller
refuses honest programs, larger turns tools elsewhere than programmed."""

POLE_RAD = 1.0e-9
"""Nearer than this [rad] to the axis next to the part, a direction leaves that joint free. Larger
keeps a joint that should turn."""

POLE_STEP_RAD = 1.0e-7
"""A piece that turns the tool axis by less than this [rad] is not cut any further: 3e-5 mm at a
lever of 300 mm. Larger leaves more of a circle beside a pole without a bound."""

TRAVEL_TIE = 1.0e-9
"""Two choices of rotary positions whose travel differs by less than this part are equally far.
Smaller lets rounding choose which way a head tilts."""

SAME_ROTARY_DEG = 1.0e-6
"""Rotary positions that differ by less are the same [deg]. Larger overlooks turns at a pole."""

NEAR_POLE_DEG = 5.0
"""A joint that is too slow within this angle of a pole is so because of the pole (GC304, not
GC303): it turns 11 times as fast there as the tool axis."""

STILL_MM = 1.0e-9
"""A tip that moves less than this [mm] stands still, and F counts degrees: rounding stays below.
Smaller reads the feed of turns in place as mm/min."""

# Motion.

TANGENT_DEG = 10.0
"""Corners of up to this angle are passed without a stop. A smaller one stops programs that write
curves as chords, which no control does; a larger one lets an axis jump by more of the feed."""

SPIRAL_PART = 0.01
"""Radii that change by more than this part make a spiral, whose extremes are looked for in another
way than those of a circle. Larger may miss overtravel, for Newton steps may miss an extreme."""

LEAST_BEND_MM = 1.0e-9
"""Newton steps to an extreme stop where the second derivative of a coordinate along an arc is below
this [mm]. Larger may miss overtravel by as much; smaller divides by rounding."""

LEAST_LOSS = 1.0e-12
"""A block whose time grows by no more than this part keeps its feed. Smaller reports rounding as a
stretched block (GC303, GC304)."""

SERVO_ARC_MM = 1.0e-7
"""How far the cubics that stand for an arc may leave it [mm]: the response leaves its own by no
more than that times the overshoot of the drive. Smaller only costs time."""

# Programs.

STRAIGHT_ON_SINE = 1.0e-9
"""Sine of the angle below which two blocks make no corner: there is nothing to cut or round."""

CORNER_REST_MM = 1.0e-9
"""A block longer than the cut of its corner by less than this [mm] is cut as a whole: so much is
rounding. Smaller refuses corners that just fit (GC404)."""

SAME_LEVEL_MM = 1.0e-9
"""A peck this near to the bottom [mm] is the last: inches must not leave a peck of 1e-14 mm."""

SAME_ANGLE_DEG = 1.0e-9
"""Angles nearer than this are the same [deg]: float noise must not cost a full turn."""
