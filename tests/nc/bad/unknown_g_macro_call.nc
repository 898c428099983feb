; unknown_g 2
G65 P9010 A1
