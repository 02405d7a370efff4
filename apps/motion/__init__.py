"""Motions of an arm judged: reaching scenes run by the control basis and by a baseline."""
