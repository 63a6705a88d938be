# Libraries without targets of their own get one here; they are exported with the components that link them.
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
add_library(kerf_cholmod INTERFACE)
target_link_libraries(kerf_cholmod INTERFACE ${CHOLMOD_LIBRARY})
target_include_directories(kerf_cholmod SYSTEM INTERFACE ${CHOLMOD_INCLUDE_DIR})

# ITK 5.2 exports no modern targets: one interface library, so that no directory-wide USE_FILE leaks into other targets.
add_library(kerf_itk INTERFACE)
target_include_directories(kerf_itk SYSTEM INTERFACE ${ITK_INCLUDE_DIRS})
target_link_libraries(kerf_itk INTERFACE ${ITK_LIBRARIES})

# FFmpeg's libraries.
pkg_check_modules(LIBAV REQUIRED libavformat>=59 libavcodec>=59 libswscale libavutil)
add_library(kerf_libav INTERFACE)
target_link_libraries(kerf_libav INTERFACE ${LIBAV_LINK_LIBRARIES})
target_include_directories(kerf_libav SYSTEM INTERFACE ${LIBAV_INCLUDE_DIRS})
