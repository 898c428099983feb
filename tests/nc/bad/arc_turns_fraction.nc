; arc_turns 2
G2 X10 I5 P1.5 F100
