; feed_missing 2
G2 X10 R5
