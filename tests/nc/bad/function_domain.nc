; function_domain 2
#1=SQRT[-1]
