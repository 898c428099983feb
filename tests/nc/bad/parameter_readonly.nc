; parameter_readonly 2
#5021=1
