; arc_wrong_center_word 2
G17 G2 X10 K5 F100
