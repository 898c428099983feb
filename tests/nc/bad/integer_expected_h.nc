; integer_expected 2
G43 H1.5
