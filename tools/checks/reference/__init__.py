"""Plain Python versions of compiled code: the oracles that tests compare it with."""
