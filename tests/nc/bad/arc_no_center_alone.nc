; arc_no_center 2
G2 F100
