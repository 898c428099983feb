; macro_unsupported 2 linuxcnc
o[5] if [1]
M2
