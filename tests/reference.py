"""The plain-Python learner, which the tests share with the benchmark."""

from ptl.benchmark.reference import ReferenceLearner, erase_loops

__all__ = ["ReferenceLearner", "erase_loops"]
