# Headers of the libraries, parsed once for the stages, once for the platform and once for the tests: their flags differ. A file names what
# it uses all the same: clang-tidy (tools/tidy.sh) and the presets `dev` and `package` compile without these.
set(POLHODE_STANDARD_HEADERS
  <algorithm> <array> <cmath> <cstddef> <cstdint> <cstring> <limits> <memory> <numbers> <optional> <span> <string> <string_view> <utility> <vector>)
set(POLHODE_ALGEBRA_HEADERS <Eigen/Core> <Eigen/Cholesky> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU>)
set(POLHODE_IMAGE_HEADERS <opencv2/core.hpp> <opencv2/imgproc.hpp>)

# polhode_precompile(NAME LINKS library... HEADERS header...): a target whose headers others take by target_precompile_headers(REUSE_FROM).
function(polhode_precompile name)
  cmake_parse_arguments(ARG "" "" "LINKS;HEADERS" ${ARGN})
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp CONTENT "")
  add_library(${name} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE ${ARG_LINKS} polhode_warnings polhode_determinism)
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
endfunction()
