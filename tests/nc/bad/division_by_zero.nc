; division_by_zero 2
#1=1/0
