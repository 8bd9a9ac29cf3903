"""The report of a run: data.py reads the folder, *_plots.py draw it, view.py is the 3-D view, page.py and index.py put pages together.

Called by perf/report.py. Nothing here looks outside the folder of a run, and the same folder gives the same page.
"""
