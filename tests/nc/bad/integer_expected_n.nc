; integer_expected 2
N1.5 G0 X1
