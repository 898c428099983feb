; arc_no_center 2 linuxcnc
G2 X10 F100
