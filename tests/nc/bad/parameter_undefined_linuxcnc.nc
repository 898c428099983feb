; parameter_undefined 2 linuxcnc
G0 X[#1234+1]
M30
