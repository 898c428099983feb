; arc_no_center 2
G90.1 G2 X10 I5 F100
