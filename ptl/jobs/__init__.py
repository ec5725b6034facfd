"""The kinds of jobs that a run consists of, a file each: what decides a result, its place, its work and its content."""

from ptl.jobs.grow import Grow
from ptl.jobs.learn import Learn
from ptl.jobs.lives import Libraries, Lives
from ptl.jobs.survey import Survey

__all__ = ["Grow", "Learn", "Libraries", "Lives", "Survey"]
