"""How far a body can move, and what need not be looked at because of it."""
