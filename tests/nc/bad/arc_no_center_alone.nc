; arc_no_center 2 linuxcnc
G2 F100
