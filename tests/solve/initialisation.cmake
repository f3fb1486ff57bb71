polhode_test(solve_start
  SOURCES initial_adjustment_test.cpp initial_seeds_test.cpp
  LINKS polhode::solve polhode_synthetic)
