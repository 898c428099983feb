; arc_wrong_center_word 2 linuxcnc
G18 G2 X10 J5 F100
