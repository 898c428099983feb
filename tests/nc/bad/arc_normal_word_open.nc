; arc_normal_word_open 2
G2 X10 Y0 I5 K3 F100
