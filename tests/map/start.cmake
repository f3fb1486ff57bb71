polhode_test(map_start SOURCES start_contest_test.cpp LINKS polhode::map polhode_synthetic)
