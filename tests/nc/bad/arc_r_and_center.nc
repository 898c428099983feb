; arc_r_and_center 2 haas
G2 X10 R5 I5 F100
