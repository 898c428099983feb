; arc_no_centre_open 2
G2 X10 Y0 F100
