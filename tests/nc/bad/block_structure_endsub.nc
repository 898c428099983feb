; block_structure 2 linuxcnc
o1 endsub
