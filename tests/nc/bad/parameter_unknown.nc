; parameter_unknown 2
#1=#2001
