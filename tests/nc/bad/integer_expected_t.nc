; integer_expected 2
T1.5
