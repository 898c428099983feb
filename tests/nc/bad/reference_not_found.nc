; reference_not_found 2
G30 X0
