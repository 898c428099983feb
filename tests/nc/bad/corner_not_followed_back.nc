; corner_not_followed 4
G1 X1 F100
X9 ,C1
X2
