; macro_unsupported 2
o100 return
