; block_structure 4 linuxcnc
o1 while [1]
o2 if [1]
o1 endwhile
o2 endif
