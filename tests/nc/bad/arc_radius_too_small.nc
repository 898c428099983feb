; arc_radius_too_small 2
G2 X10 R4.99 F100
