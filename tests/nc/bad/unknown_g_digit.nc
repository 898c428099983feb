; unknown_g 2
G61.7
