"""Collision: from bodies that move along a path to their first contact, in seven rooms.

The rooms in the order of their floors; each imports only from those before it.

geometry:  what is true of triangles and boxes at one pose: the certified triangle test, nearest
           points, poses along the path.
bodies:    the checked pairs on the device: regions, trees, what is within reach, contact keys.
bounds:    how far a body can leave the chord between two poses, how far the machine can be from
           its path, and what need not be looked at because of it.
instants:  what pairs do at single instants: which touch, where, which are nearest or inside.
baseline:  the methods that the search is compared with: every sample, and the seed paper's.
search:    proofs over time: first contact, near misses, clearances, contact intervals. It knows
           nothing of the baseline, nor the baseline of it.
views:     what pictures ask: distances at chosen instants, and what an eye sees.

The detector stands above the rooms: it chooses the method and goes through the path tool by tool.
"""
