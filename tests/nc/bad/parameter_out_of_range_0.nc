; parameter_out_of_range 2 linuxcnc
#1=#0
