"""Checks of arguments, progress of long calls, how results print: the lowest layer.

Every error message names the argument, its value and the rule. The package uses NumPy and the
core only; all other packages use it. Its only physics is which moments a body can have.
"""
