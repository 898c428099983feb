; arc_no_center 2
G2 X10 F100
