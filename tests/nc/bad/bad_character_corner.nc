; bad_character 3 linuxcnc
G1 X1 F100
X2 ,R5
