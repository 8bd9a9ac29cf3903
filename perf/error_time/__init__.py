"""Error against run time: what perf/error_time.py is made of.

problem: one description of a scene for all codes; peers: its LAMMPS and LIGGGHTS decks; engine: runs, cache, clock;
closed_forms: exact references; scenes_exact, scenes_paths, scenes_bulk: the scenes; page: the report.
"""
