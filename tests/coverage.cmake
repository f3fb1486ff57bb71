# Tests against stages whose branches are counted (tools/coverage.sh). Only those stages are compiled anew, without optimisation; their objects
# stand before their libraries, so that nothing is taken from there. All else is what the build has. No part of the build by itself.
set(counted_stages base geometry solve image mask features tracks initialisation map shape motion bus pipeline)
# With these without optimisation the pipeline's tests would take hours: pixels, solvers and the selection of a start.
set(slow_stages solve image mask features initialisation)

foreach(stage ${counted_stages})
  get_target_property(names polhode_${stage} SOURCES)
  get_target_property(links polhode_${stage} LINK_LIBRARIES)
  get_target_property(includes polhode_${stage} INCLUDE_DIRECTORIES)
  list(TRANSFORM names PREPEND "${PROJECT_SOURCE_DIR}/fsw/${stage}/")
  add_library(counted_${stage} OBJECT EXCLUDE_FROM_ALL ${names})
  target_include_directories(counted_${stage} PRIVATE ${includes})
  target_compile_options(counted_${stage} PRIVATE -O0 --coverage)
  target_link_libraries(counted_${stage} PRIVATE ${links})
endforeach()

function(polhode_counted name test)
  list(TRANSFORM ARGN REPLACE "(.+)" "$<TARGET_OBJECTS:counted_\\1>")
  get_target_property(links ${test} LINK_LIBRARIES)
  add_executable(${name} EXCLUDE_FROM_ALL $<TARGET_OBJECTS:${test}> ${ARGN})
  target_link_libraries(${name} PRIVATE ${links} --coverage)
endfunction()

foreach(stage ${counted_stages})
  if(NOT stage STREQUAL pipeline)
    polhode_counted(counted_test_${stage} test_${stage} ${stage})
  endif()
endforeach()
polhode_counted(counted_test_solve_start test_solve_start solve)
list(REMOVE_ITEM counted_stages ${slow_stages})
polhode_counted(counted_test_pipeline test_pipeline ${counted_stages})
