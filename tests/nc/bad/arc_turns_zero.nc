; arc_turns 2
G2 X10 I5 P0 F100
