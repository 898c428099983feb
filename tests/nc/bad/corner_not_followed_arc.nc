; corner_not_followed 4
G1 X1 F100
X9 ,R1
G2 X9 Y9 R9
