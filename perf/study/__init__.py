"""Parts of perf/study.py: what is run (plan), running it (runner), what it means (findings), the report (page)."""
