; inverse_feed_missing 3
G93 G1 X1 F2
X2
