; value_unknown 3
#101=[#500+1]
IF[#101EQ1]GOTO9
N9M30
