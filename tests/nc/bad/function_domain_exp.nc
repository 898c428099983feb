; function_domain 2
#1=EXP[1000]
