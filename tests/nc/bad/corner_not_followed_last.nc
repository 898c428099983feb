; corner_not_followed 4
G1 X1 F100
X2 ,R5
M30
