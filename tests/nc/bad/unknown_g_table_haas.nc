; unknown_g 3 haas
G254
G2 X1 I.5 F1
