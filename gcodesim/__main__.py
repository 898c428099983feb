"""Runs the command line as ``python -m gcodesim``."""

from gcodesim.cli import main

main(prog_name="gcodesim")
