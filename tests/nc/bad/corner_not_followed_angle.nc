; corner_not_followed 3
G1 X1 F100
X9 ,A30
