; integer_expected 2
GOTO 1.5
