; arc_zero_radius 2 linuxcnc
G2 X10 I0 J0 F100
