; function_domain 2 linuxcnc
#1=[-8**0.5]
