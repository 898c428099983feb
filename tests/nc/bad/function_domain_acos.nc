; function_domain 2
#1=ACOS[1.1]
