; unknown_g 2 haas
G92.1
