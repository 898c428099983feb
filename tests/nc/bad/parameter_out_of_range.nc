; parameter_out_of_range 2
#99999=1
