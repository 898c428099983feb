; corner_not_followed 2
G0 X9 ,R1
X9 Y9
