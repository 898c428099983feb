; arc_r_no_end_open 2
G2 X0 Y0 R5 F100
