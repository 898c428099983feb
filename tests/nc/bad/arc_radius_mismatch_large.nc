; arc_radius_mismatch 2 linuxcnc (0.06 percent, but more than 2.828 mm)
G2 X10003 I5000 F100
