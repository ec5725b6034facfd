"""The kinds of jobs of a run, one file each: the inputs of a result, its path, its computation and its contents."""

from ptl.jobs.grow import Grow
from ptl.jobs.learn import Learn
from ptl.jobs.lives import Libraries, Lives
from ptl.jobs.survey import Survey

__all__ = ["Grow", "Learn", "Libraries", "Lives", "Survey"]
