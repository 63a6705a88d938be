# kerf_add_widgets(<Name> SOURCES … LINK …): a static library KerfWidgets<Name>; headers are included from Widgets/.
function(kerf_add_widgets name)
  cmake_parse_arguments(W "" "" "SOURCES;LINK" ${ARGN})
  add_library(KerfWidgets${name} STATIC ${W_SOURCES})
  add_library(Kerf::Widgets${name} ALIAS KerfWidgets${name})
  set_target_properties(KerfWidgets${name} PROPERTIES AUTOMOC ON)
  target_include_directories(KerfWidgets${name} PUBLIC "${CMAKE_SOURCE_DIR}/Widgets")
  target_link_libraries(KerfWidgets${name} PUBLIC Qt5::Widgets ${W_LINK})
endfunction()

# kerf_add_module(<Name> SOURCES … LINK …): a Qt plugin that KerfApp finds; <name>.json beside it is its metadata.
function(kerf_add_module name)
  cmake_parse_arguments(M "" "" "SOURCES;LINK" ${ARGN})
  add_library(Kerf${name}Module MODULE ${M_SOURCES})
  set_target_properties(Kerf${name}Module PROPERTIES AUTOMOC ON PREFIX ""
    LIBRARY_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin/plugins" INSTALL_RPATH "$ORIGIN/../..")
  target_link_libraries(Kerf${name}Module PRIVATE Kerf::Framework ${M_LINK})
  target_link_options(Kerf${name}Module PRIVATE -Wl,--as-needed)
  # The program is useless without its modules: building KerfApp builds them.
  if(TARGET KerfApp)
    add_dependencies(KerfApp Kerf${name}Module)
  endif()
  install(TARGETS Kerf${name}Module LIBRARY DESTINATION lib/kerf/plugins)
endfunction()
