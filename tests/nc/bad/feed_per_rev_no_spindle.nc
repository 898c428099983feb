; feed_per_rev_no_spindle 2
G95 G1 X1 F0.1
