"""Campaigns: many scenes, many settings, one table.

scene_space          what varies, over which range; the scene that a point means
plan, book           PLAN.toml, checked; each run's tasks and keys
store, tasks         places, locks, appearing whole; what workers do
cluster, execution   workers; what is missing, in order, with progress
measures             a run's row and its frames'
results, summaries   the tables; distributions, intervals, pairs
report, figures      the page
"""
