# `cmake --install`: libraries, headers, the shell, and a package for find_package(Kerf).
include(CMakePackageConfigHelpers)
set(_package "${CMAKE_INSTALL_LIBDIR}/cmake/Kerf")
install(TARGETS kerf RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
install(TARGETS kerf_cholmod kerf_itk kerf_libav EXPORT KerfTargets)
# The layout of Eigen's fixed-size types follows the instruction set: who links Kerf compiles for the same one.
target_compile_options(KerfCore INTERFACE $<INSTALL_INTERFACE:-march=${KERF_BASELINE}>)
install(EXPORT KerfTargets NAMESPACE Kerf:: DESTINATION "${_package}")
configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/KerfConfig.cmake.in" "${CMAKE_BINARY_DIR}/KerfConfig.cmake"
  INSTALL_DESTINATION "${_package}")
write_basic_package_version_file("${CMAKE_BINARY_DIR}/KerfConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_BINARY_DIR}/KerfConfig.cmake" "${CMAKE_BINARY_DIR}/KerfConfigVersion.cmake"
  DESTINATION "${_package}")
install(FILES "${CMAKE_SOURCE_DIR}/LICENSE" "${CMAKE_SOURCE_DIR}/README.md" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
