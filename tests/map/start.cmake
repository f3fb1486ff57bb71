polhode_test(map_start SOURCES start_contest_test.cpp LINKS polhode::map polhode_synthetic)

# Benchmarks of the start share its synthetic bodies: built with the tests, run by hand.
add_subdirectory("${PROJECT_SOURCE_DIR}/hil/benchmarks" "${PROJECT_BINARY_DIR}/hil/benchmarks")
