# Builds for the flight computers' architecture on a machine of another: Debian's cross compiler, libraries from the sysroot that
# `tools/setup.sh arm64` makes, programs under QEMU where the build or ctest runs one.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)

# The same place stands in tools/setup.sh.
if("$ENV{XDG_CACHE_HOME}" STREQUAL "")
  set(CMAKE_SYSROOT $ENV{HOME}/.cache/polhode/sysroot-arm64)
else()
  set(CMAKE_SYSROOT $ENV{XDG_CACHE_HOME}/polhode/sysroot-arm64)
endif()

set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_LIBDIR} ${CMAKE_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${CMAKE_SYSROOT}/usr/share/pkgconfig)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${CMAKE_SYSROOT})

# The least of the arm64 processors: a program that asks for more stops there.
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static -cpu cortex-a53 -L ${CMAKE_SYSROOT})
string(JOIN " " POLHODE_RUNNER ${CMAKE_CROSSCOMPILING_EMULATOR})
set(POLHODE_RUNNER "${POLHODE_RUNNER}" CACHE STRING "Command that runs the programs built, for tools/check_arm64.sh")
