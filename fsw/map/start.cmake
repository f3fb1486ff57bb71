# The start of a map: core, hypotheses, contest.
target_sources(polhode_map PRIVATE
  hypotheses.cpp
  initialise.cpp
  start_contest.cpp
  start_core.cpp
  start_extend.cpp
  start_finish.cpp)
