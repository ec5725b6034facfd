"""The figures of the report, one module each: files in, a PNG with an SVG twin and the plotted numbers out.

Every module has a function that turns its inputs into a tidy data frame and one that draws the figure. A
module imports only what it draws with, so that editing one figure redraws that figure and no other.
"""
