; arc_zero_radius 2
G2 X10 I0 J0 F100
