; unknown_g 2
G7.1 C20
