; unknown_m 2
M123
M123
M123
M30
