# What the start of a map needs of the solvers.
target_sources(polhode_solve PRIVATE
  affine_factorisation.cpp
  constant_rate_grid.cpp
  homography.cpp
  relative_pose.cpp
  initial_adjustment.cpp
  initial_gauge.cpp
  initial_residuals.cpp)
target_link_libraries(polhode_solve PRIVATE opencv_core opencv_calib3d opengv)
