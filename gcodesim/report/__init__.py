"""Reports: views of one check, for people and for programs."""
