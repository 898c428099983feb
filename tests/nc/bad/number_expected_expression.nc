; number_expected 2
G0 X[1+]
