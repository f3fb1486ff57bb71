polhode_test(solve_start
  SOURCES start_adjustment_test.cpp start_seeds_test.cpp
  LINKS polhode::solve polhode_synthetic)
