; feed_missing 3
G94 G1 X1 F100 S1000
G95 X2
