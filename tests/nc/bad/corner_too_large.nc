; corner_too_large 4
G1 X1 F100
X9 ,R5
Y4.9
