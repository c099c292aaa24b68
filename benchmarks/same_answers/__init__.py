"""Answers that were frozen once, beside those of the code as it is now.

A change inside the package should not change an answer: ``python -m benchmarks.same_answers`` asks
the questions of :mod:`benchmarks.same_answers.catalogue` again and tells every difference.
"""
