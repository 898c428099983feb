; cycle_pecks_open 3
G0 Z50
G83 X0 Z0 R10 F100
