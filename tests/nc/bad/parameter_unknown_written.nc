; parameter_unknown 2
#5221=3
