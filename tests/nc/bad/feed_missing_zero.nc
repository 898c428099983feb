; feed_missing 2
G1 X2 F0
