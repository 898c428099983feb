; feed_missing 3
G0 X1
G1 X2
