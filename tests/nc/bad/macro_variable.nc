; macro_unsupported 2
#1=5
