# Debian packages (tools/package.sh): polhode, libpolhode1, libpolhode-dev, polhode-ground, and debug symbols apart.
set(PACKAGING ${PROJECT_SOURCE_DIR}/platform/debian)
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
# Who makes packages for others to install names himself: he answers for them, and there is nobody behind the default's address.
set(POLHODE_PACKAGE_CONTACT "The Polhode authors <dev@polhode.org>" CACHE STRING "Maintainer of the Debian packages: NAME <ADDRESS>")
if(NOT POLHODE_PACKAGE_CONTACT MATCHES "^[^<>\n]+ <[^<>@ ]+@[^<>@ ]+>$")
  message(FATAL_ERROR "POLHODE_PACKAGE_CONTACT is '${POLHODE_PACKAGE_CONTACT}'; allowed is NAME <ADDRESS>")
endif()
set(CPACK_PACKAGE_CONTACT ${POLHODE_PACKAGE_CONTACT})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_SOURCE_DIR}/build/packages)
set(CPACK_COMPONENTS_ALL program library development ground)
set(CPACK_POLHODE_STRIP ${CMAKE_STRIP})  # for strip_archives.cmake
if(CMAKE_CROSSCOMPILING)  # config/aarch64.cmake. What is for every architecture is packaged without it.
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
  set(CPACK_PACKAGE_DIRECTORY ${PROJECT_SOURCE_DIR}/build/packages-arm64)
  set(CPACK_COMPONENTS_ALL program library development)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_SYSROOT}/lib/aarch64-linux-gnu ${CMAKE_SYSROOT}/usr/lib/aarch64-linux-gnu)
endif()
set(CPACK_SET_DESTDIR ON)  # /etc/polhode lies outside of the prefix
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_PRE_BUILD_SCRIPTS ${PACKAGING}/strip_archives.cmake)
set(same "(= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")

# component, package, section, first line and body of its description
macro(polhode_package component package section summary)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  string(JOIN "\n" body ${ARGN})
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${summary}\n${body}")
  install(FILES ${CMAKE_BINARY_DIR}/packaging/copyright DESTINATION share/doc/${package} COMPONENT ${component})
  install(FILES ${CMAKE_BINARY_DIR}/packaging/changelog.Debian.gz DESTINATION share/doc/${package} COMPONENT ${component})
endmacro()

# Compressed as policy asks, without a time, so that the same sources give the same octets.
function(compress from to)
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/packaging)
  execute_process(COMMAND gzip -9nc ${from} OUTPUT_FILE ${CMAKE_BINARY_DIR}/packaging/${to} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
configure_file(${PACKAGING}/changelog.in ${CMAKE_BINARY_DIR}/packaging/changelog @ONLY)
configure_file(${PACKAGING}/copyright.in ${CMAKE_BINARY_DIR}/packaging/copyright @ONLY)
compress(${CMAKE_BINARY_DIR}/packaging/changelog changelog.Debian.gz)
compress(${PACKAGING}/polhode.1 polhode.1.gz)

polhode_package(program polhode science "motion and shape of a tumbling object from one camera"
  "Watches an unknown tumbling object with one camera. For each frame it estimates\nattitude, position and motion, and the object's shape."
  "This package has the program, its configurations and a service.")
set(CPACK_DEBIAN_PROGRAM_DEBUGINFO_PACKAGE ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "adduser")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_CONTROL_EXTRA "${PACKAGING}/postinst;${PACKAGING}/postrm;${PACKAGING}/conffiles")
install(FILES config/live.toml DESTINATION /etc/polhode COMPONENT program)
install(FILES ${CMAKE_BINARY_DIR}/packaging/polhode.1.gz DESTINATION share/man/man1 COMPONENT program)
install(FILES ${PACKAGING}/completion.bash RENAME polhode DESTINATION share/bash-completion/completions COMPONENT program)

polhode_package(library libpolhode1 libs "motion of a tumbling object: library for C"
  "The component behind a C interface, for flight frameworks written in C or C++.")
set(CPACK_DEBIAN_LIBRARY_DEBUGINFO_PACKAGE ON)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA "${PACKAGING}/library/triggers")

polhode_package(development libpolhode-dev libdevel "motion of a tumbling object: headers and static libraries"
  "polhode.h for C, the public headers for C++20, static libraries, and files for\nCMake and pkg-config.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libpolhode1 ${same}, libceres-dev, libeigen3-dev, libflann-dev, liblz4-dev, libopencv-dev, libopengv-dev, libsleef-dev")

polhode_package(ground polhode-ground science "motion of a tumbling object: ground side of the bus"
  "Definitions of packets and commands (XTCE for YAMCS and others, CSV for\nccsdspy), clients in C and Python, and the interface control document.")
set(CPACK_DEBIAN_GROUND_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_GROUND_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_GROUND_PACKAGE_DEPENDS "python3")
set(CPACK_DEBIAN_GROUND_PACKAGE_CONTROL_EXTRA "${PACKAGING}/ground/postinst;${PACKAGING}/ground/prerm")
install(FILES config/bus/polhode.xtce.xml config/bus/polhode_commands.xtce.xml DESTINATION share/polhode/bus COMPONENT ground)
install(DIRECTORY config/bus/ccsdspy DESTINATION share/polhode/bus COMPONENT ground)
install(DIRECTORY platform/transport/client/c DESTINATION share/polhode/client COMPONENT ground)
install(FILES platform/transport/client/python/example.py DESTINATION share/polhode/client/python COMPONENT ground)
install(DIRECTORY platform/transport/client/python/polhode_bus DESTINATION lib/python3/dist-packages COMPONENT ground
  FILES_MATCHING PATTERN "*.py" PATTERN __pycache__ EXCLUDE)
set(interface_control ${CMAKE_BINARY_DIR}/packaging/interface_control.md)
execute_process(COMMAND python3 ${PROJECT_SOURCE_DIR}/tools/generate_bus.py --document ${interface_control} COMMAND_ERROR_IS_FATAL ANY)
install(FILES ${interface_control} DESTINATION share/doc/polhode COMPONENT program)
install(FILES ${interface_control} docs/bus.md docs/security.md DESTINATION share/doc/polhode-ground COMPONENT ground)
include(CPack)
