; main_program_repeats 2
M99
G0 X1
