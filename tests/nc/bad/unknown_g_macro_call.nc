; unknown_g 2
G66 P9010 A1
