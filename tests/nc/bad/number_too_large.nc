; number_too_large 2
G0 X99999999999999
