; feed_negative 2
G1 X2 F-5
