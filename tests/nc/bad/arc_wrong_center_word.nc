; arc_wrong_center_word 2 linuxcnc
G17 G2 X10 K5 F100
