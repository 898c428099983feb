; macro_unsupported 2
GOTO 10
