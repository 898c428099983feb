; parameter_readonly 2
#0=1
