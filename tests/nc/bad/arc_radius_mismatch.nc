; arc_radius_mismatch 2 linuxcnc
G2 X10.1 I5 F100
