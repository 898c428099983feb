; corner_too_large 3
G1 X1 F100
X9 ,R0
Y4.9
