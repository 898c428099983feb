; division_by_zero 2
#1=5MOD0
