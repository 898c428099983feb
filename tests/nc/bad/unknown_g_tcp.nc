; unknown_g 2
G43.4 H1
