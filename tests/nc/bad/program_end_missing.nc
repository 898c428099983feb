; program_end_missing 3
G0 X1
G0 X2
